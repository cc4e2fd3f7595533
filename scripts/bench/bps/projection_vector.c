/*
  Projection of a field with one component an axis: CEED's BP2. The equations are those of projection.c.
*/
#define BP_VECTOR
#include "projection.c"
