/* SPDX-License-Identifier: Apache-2.0 */
/* Owns the shutdown of the C++ runtime that is linked into the layer: frees at unload what that
 * runtime allocated at load. Compiled only if the runtime is linked statically. */

/* __gnu_cxx::__freeres() frees the pool for exceptions that are thrown when memory is short.
 * libstdc++ allocates these 72 KiB at load and otherwise never frees them, because it expects to
 * stay loaded until exit. The loader opens and closes the layer with every instance. Weak, because
 * a libstdc++ may lack the pool. */
void cxx_runtime_free(void) __asm__("_ZN9__gnu_cxx9__freeresEv") __attribute__((weak));

__attribute__((destructor)) static void cxx_runtime_end(void)
{
    if (cxx_runtime_free) {
        cxx_runtime_free();
    }
}
