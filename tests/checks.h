#pragma once
/*
  Check's assertions without its record of the last place passed, a write to a file for each: a test that dies in a
  process of its own is reported by this place, and ours run in one process.
*/
#include <check.h>

#define _mark_point(file, line) ((void)0)
