#pragma once
/*
  What flows through a point, beside its law.
*/

/* A bit of a kernel point's traits, which no law has: water leaves and enters at once, and its pressure is that of a steady flow. */
#define MPM_POINT_DRAINED (1u << 31)
