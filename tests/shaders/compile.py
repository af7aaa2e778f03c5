# SPDX-License-Identifier: Apache-2.0
"""Compiles the shaders of paths.cases, and those of assembly.cases, to a header with a table of struct
path_case (tests/shaders/paths_test.c)."""

import argparse
import pathlib
import subprocess
import sys
import tempfile

HEAD = """#version 460
#extension GL_EXT_ray_query : require

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const bool disabled = false;
layout(constant_id = 1) const uint samples = 4;
layout(constant_id = 2) const float intensity = 0.25;
layout(set = 0, binding = 0) uniform accelerationStructureEXT top;
layout(set = 0, binding = 1, rgba32f) uniform image2D picture;
layout(set = 1, binding = 2, std430) buffer Numbers { uint numbers[]; };
layout(set = 1, binding = 5) uniform Uniforms { uint flag; uvec2 size; };
layout(push_constant, std430) uniform Constants { uint rays; uint width; uint height; uvec2 pair; uint list[2]; } push;

void trace(accelerationStructureEXT traced)
{
    rayQueryEXT query;
    rayQueryInitializeEXT(query, traced, 0, 0xff, vec3(0), 0.0, vec3(0, 0, 1), 1.0);
    while (rayQueryProceedEXT(query))
        rayQueryTerminateEXT(query);
}

bool shadow(vec3 origin)
{
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top, 0, 0xff, origin, 0.0, vec3(0, 0, 1), 1.0);
    while (rayQueryProceedEXT(query)) {
    }
    return rayQueryGetIntersectionTypeEXT(query, true) != 0;
}

uint hit_or_nothing(uint wanted)
{
    if (wanted == 0)
        return 0;
    return shadow(vec3(0)) ? 1 : 2;
}

void change(inout uint value, uint unknown)
{
    if (unknown == 3)
        return;
    value = unknown;
}

void main()
{
"""

ASSEMBLY = """               OpCapability Shader
               OpCapability RayQueryKHR
               OpExtension "SPV_KHR_ray_query"
               OpMemoryModel Logical GLSL450
               {entry}
               OpDecorate %top DescriptorSet 0
               OpDecorate %top Binding 0
               OpDecorate %block Block
               OpMemberDecorate %block 0 Offset 0
               OpDecorate %unknowns DescriptorSet 0
               OpDecorate %unknowns Binding 1
       %void = OpTypeVoid
   %function = OpTypeFunction %void
       %bool = OpTypeBool
       %uint = OpTypeInt 32 0
      %float = OpTypeFloat 32
       %vec3 = OpTypeVector %float 3
  %structure = OpTypeAccelerationStructureKHR
      %query = OpTypeRayQueryKHR
      %block = OpTypeStruct %uint
  %p_uniform = OpTypePointer Uniform %block
     %p_uint = OpTypePointer Uniform %uint
      %p_top = OpTypePointer UniformConstant %structure
    %p_query = OpTypePointer Function %query
        %top = OpVariable %p_top UniformConstant
   %unknowns = OpVariable %p_uniform Uniform
     %uint_0 = OpConstant %uint 0
     %uint_1 = OpConstant %uint 1
    %float_0 = OpConstant %float 0
    %float_1 = OpConstant %float 1
     %vec3_0 = OpConstantComposite %vec3 %float_0 %float_0 %float_0
       %true = OpConstantTrue %bool
       %main = OpFunction %void None %function
      %start = OpLabel
          %q = OpVariable %p_query Function
    %pointer = OpAccessChain %p_uint %unknowns %uint_0
    %unknown = OpLoad %uint %pointer
  %condition = OpIEqual %bool %unknown %uint_1
         %as = OpLoad %structure %top
"""
COMPUTE = """OpEntryPoint GLCompute %main "main" %top %unknowns
               OpExecutionMode %main LocalSize 1 1 1"""
FRAGMENT = """OpEntryPoint Fragment %main "main" %top %unknowns
               OpExecutionMode %main OriginUpperLeft"""


def expectation(line, where):
    """(certain, push constants or None) of a line, or None if it is none."""
    words = line.split()
    if not words or words[0] not in ("certain", "possible"):
        return None
    push = None if words[1:] == ["unknown"] else [int(word) for word in words[1:]]
    if push is not None and len(push) != 3:
        sys.exit(f"{where}: three push constants, or unknown: {line}")
    return words[0] == "certain", push


def read_cases(path):
    """[(name, expectations, lines of main())], and the names of fragment shaders."""
    cases, fragments = [], set()
    for number, line in enumerate(path.read_text().splitlines(), 1):
        where = f"{path}:{number}"
        if line.startswith("case "):
            cases.append((line[5:], [], []))
        elif line.startswith("    "):
            cases[-1][2].append(line)
        elif line == "fragment":
            fragments.add(cases[-1][0])
        elif line and not line.startswith("#"):
            expected = expectation(line, where)
            if not expected:
                sys.exit(f"{where}: expected case, certain, possible or a body: {line}")
            cases[-1][1].append(expected)
    return cases, fragments


def run(*command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if result.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{result.stdout}{result.stderr}")


def words_of(path):
    data = path.read_bytes()
    return [int.from_bytes(data[i:i + 4], "little") for i in range(0, len(data), 4)]


def modules(arguments, folder):
    """(name, expectations, words) of each module."""
    source, plain, optimized = (folder / name for name in ("a.comp", "a.spv", "o.spv"))
    for name, expected, body in read_cases(arguments.cases)[0]:
        source.write_text(HEAD + "\n".join(body) + "\n}\n")
        run(arguments.glslang, "--quiet", "--target-env", "vulkan1.2", "-o", plain, source)
        run(arguments.tools / "spirv-opt", "-O", plain, "-o", optimized)
        yield name, expected, words_of(plain)
        yield name + ", optimized", expected, words_of(optimized)
    cases, fragments = read_cases(arguments.assembly)
    for name, expected, body in cases:
        entry = FRAGMENT if name in fragments else COMPUTE
        source.write_text(ASSEMBLY.format(entry=entry) + "\n".join(body) + "\nOpFunctionEnd\n")
        run(arguments.tools / "spirv-as", "--target-env", "vulkan1.2", source, "-o", plain)
        run(arguments.tools / "spirv-val", "--target-env", "vulkan1.2", plain)
        yield name, expected, words_of(plain)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--glslang", required=True)
    parser.add_argument("--tools", type=pathlib.Path, required=True, help="the folder of SPIRV-Tools")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("cases", type=pathlib.Path)
    parser.add_argument("assembly", type=pathlib.Path)
    arguments = parser.parse_args()
    arrays, rows = [], []
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, expected, words) in enumerate(modules(arguments, pathlib.Path(folder))):
            arrays.append(f"static const uint32_t words_{number}[] = {{{', '.join(map(hex, words))}}};\n")
            for certain, push in expected:
                rows.append(f'    {{"{name}", words_{number}, sizeof(words_{number}), {str(certain).lower()}, '
                            f"{str(push is not None).lower()}, {{{', '.join(map(str, push or [0]))}}}}},\n")
    arguments.out.write_text("".join(arrays) + "\nstatic const struct path_case path_cases[] = {\n" +
                             "".join(rows) + "};\n")


if __name__ == "__main__":
    main()
