/*
  A program that was compiled for another processor says so: no processor has all of these instructions.
*/
#include "run/processor.h"
#include "unit.h"

START_TEST(lacks)
{
  ck_assert_ptr_null(MpmProcessorLacks(0));
  ck_assert_ptr_null(MpmProcessorLacks(mpm_compiled_with));
#if defined(__x86_64__)
  ck_assert_ptr_nonnull(MpmProcessorLacks(~0u));
#endif
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {lacks};

  return UnitRun(&argc, &argv, "processor", sizeof(tests) / sizeof(tests[0]), tests);
}
