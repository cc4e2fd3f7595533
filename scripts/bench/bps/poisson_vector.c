/*
  Poisson's equation for each of the components along the axes: CEED's BP4. The equations are those of poisson.c.
*/
#define BP_VECTOR
#include "poisson.c"
