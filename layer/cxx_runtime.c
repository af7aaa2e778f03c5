/* SPDX-License-Identifier: Apache-2.0 */
/* Owns the end of the C++ runtime that is linked into the layer: it gives back at unload what that
 * runtime allocated at load; compiled only where the runtime is linked in statically. */

/* __gnu_cxx::__freeres(): frees the pool for exceptions thrown when memory is short, 72 KiB that
 * libstdc++ takes at load and otherwise never frees, because it expects to stay until exit. The
 * loader opens and closes the layer with every instance. Weak: a libstdc++ may have no such pool.
 */
void cxx_runtime_free(void) __asm__("_ZN9__gnu_cxx9__freeresEv") __attribute__((weak));

__attribute__((destructor)) static void cxx_runtime_end(void)
{
    if (cxx_runtime_free) {
        cxx_runtime_free();
    }
}
