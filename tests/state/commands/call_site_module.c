/* SPDX-License-Identifier: Apache-2.0 */
/* A library that looks like a layer, or, compiled with PLAIN, like any other library. */
#ifdef PLAIN
#define ENTRY plain_entry
#else
#define ENTRY vkNegotiateLoaderLayerInterfaceVersion
#endif

int ENTRY(void);
int ENTRY(void)
{
    return 0;
}
