/* The bcryptprimitives.dll that Wine 8 lacks: Rust's standard library takes its random numbers from it. For tests alone. */

#include <windows.h>

#include <ntsecapi.h>

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE octets, SIZE_T length) {
    return RtlGenRandom(octets, (ULONG)length);
}
