/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks and pauses. */
#include "src/platform/clock.h"

#include <windows.h>

enum { MILLISECOND = 1000000, SECOND = 1000000000, TICK = 100 /* of FILETIME */ };

static const uint64_t ticks_from_1601_to_1970 = UINT64_C(116444736000000000);

uint64_t clock_tick(void)
{
    return GetTickCount64();
}

uint64_t clock_monotonic(void)
{
    LARGE_INTEGER count, frequency;
    QueryPerformanceCounter(&count);
    QueryPerformanceFrequency(&frequency);
    uint64_t now = (uint64_t)count.QuadPart, rate = (uint64_t)frequency.QuadPart;
    return now / rate * SECOND + now % rate * SECOND / rate;
}

static uint64_t ticks_of(FILETIME time)
{
    return (uint64_t)time.dwHighDateTime << 32 | time.dwLowDateTime;
}

uint64_t clock_process_cpu(void)
{
    FILETIME creation, end, kernel = {0}, user = {0};
    GetProcessTimes(GetCurrentProcess(), &creation, &end, &kernel, &user);
    return (ticks_of(kernel) + ticks_of(user)) * TICK;
}

struct utc_time clock_utc(void)
{
    FILETIME time;
    GetSystemTimeAsFileTime(&time);
    uint64_t ticks = ticks_of(time) - ticks_from_1601_to_1970;
    return (struct utc_time){ticks / (SECOND / TICK), (uint32_t)(ticks % (SECOND / TICK)) * TICK};
}

void clock_sleep(uint64_t nanoseconds)
{
    Sleep((DWORD)((nanoseconds + MILLISECOND - 1) / MILLISECOND));
}

void clock_yield(void)
{
    SwitchToThread();
}
