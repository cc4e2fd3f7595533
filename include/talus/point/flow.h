#pragma once
/*
  Flow of water through a point, beside its law.
*/

/* A bit of a kernel point's traits, of no law: water leaves and enters at once, with the pressure of a steady flow. */
#define MPM_POINT_DRAINED (1u << 31)
