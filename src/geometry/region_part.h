#pragma once
/*
  The part of a region in a box.
*/
#include "geometry/geometry.h"

/*
  Volume of what lies both in the box between two corners and in the region, without its tolerance, and its centroid.
  Exact for boxes, discs, polygons, layers and their prisms; spheres by quadrature. Cylinders at an angle to the axes
  are sampled.
*/
PetscReal MpmRegionPart(MpmRegion region, const PetscReal lower[], const PetscReal upper[], PetscReal centroid[]);
/* As MpmRegionPart() of any set of places, by samples; for what has no simpler form. */
PetscReal MpmSampledPart(PetscInt dim, PetscBool (*contains)(const void *set, const PetscReal x[]), const void *set,
                         const PetscReal lower[], const PetscReal upper[], PetscReal centroid[]);
/* PETSC_FALSE where no surface of the region comes nearer to x than this distance, m. */
PetscBool MpmRegionIsNearEdge(MpmRegion region, const PetscReal x[], PetscReal distance);
