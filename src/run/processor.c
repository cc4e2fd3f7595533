/*
  Instructions of the processor. Compiled for any processor of the architecture, unlike the other files.
*/
#include <stddef.h>
#include "run/processor.h"

#if defined(__x86_64__) || defined(__i386__)
const char *MpmProcessorLacks(unsigned instructions)
{
  __builtin_cpu_init();
  if (instructions & MPM_AVX && !__builtin_cpu_supports("avx")) return "avx";
  if (instructions & MPM_AVX2 && !__builtin_cpu_supports("avx2")) return "avx2";
  if (instructions & MPM_FMA && !__builtin_cpu_supports("fma")) return "fma";
  if (instructions & MPM_BMI2 && !__builtin_cpu_supports("bmi2")) return "bmi2";
  if (instructions & MPM_AVX512F && !__builtin_cpu_supports("avx512f")) return "avx512f";
  if (instructions & MPM_AVX512VL && !__builtin_cpu_supports("avx512vl")) return "avx512vl";
  if (instructions & MPM_AVX512BW && !__builtin_cpu_supports("avx512bw")) return "avx512bw";
  if (instructions & MPM_AVX512DQ && !__builtin_cpu_supports("avx512dq")) return "avx512dq";
  if (instructions & MPM_AVX512ER && !__builtin_cpu_supports("avx512er")) return "avx512er";
  return NULL;
}
#else
const char *MpmProcessorLacks(unsigned instructions)
{
  (void)instructions;
  return NULL;
}
#endif
