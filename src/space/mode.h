#pragma once
/*
  Modes of the sums over points.
*/

/* Stress of the points in their forces. */
typedef enum {
  MPM_MODE_END,  /* by the laws, at the step's end */
  MPM_MODE_START /* of the step's start: nothing moves; physics without means over cells */
} MpmMode;
