#pragma once
/*
  Instructions that a program was compiled with, and whether the processor has them.
*/

typedef enum {
  MPM_AVX      = 1 << 0,
  MPM_AVX2     = 1 << 1,
  MPM_FMA      = 1 << 2,
  MPM_BMI2     = 1 << 3,
  MPM_AVX512F  = 1 << 4,
  MPM_AVX512VL = 1 << 5,
  MPM_AVX512BW = 1 << 6,
  MPM_AVX512DQ = 1 << 7,
  MPM_AVX512ER = 1 << 8
} MpmInstructions;

/* MpmInstructions of the file that includes this. */
static const unsigned mpm_compiled_with = 0
#ifdef __AVX__
                                          | MPM_AVX
#endif
#ifdef __AVX2__
                                          | MPM_AVX2
#endif
#ifdef __FMA__
                                          | MPM_FMA
#endif
#ifdef __BMI2__
                                          | MPM_BMI2
#endif
#ifdef __AVX512F__
                                          | MPM_AVX512F
#endif
#ifdef __AVX512VL__
                                          | MPM_AVX512VL
#endif
#ifdef __AVX512BW__
                                          | MPM_AVX512BW
#endif
#ifdef __AVX512DQ__
                                          | MPM_AVX512DQ
#endif
#ifdef __AVX512ER__
                                          | MPM_AVX512ER
#endif
  ;

/* The first of these instructions that this processor lacks, by its name in /proc/cpuinfo; NULL: none. */
const char *MpmProcessorLacks(unsigned instructions);
