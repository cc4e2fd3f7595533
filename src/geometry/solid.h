#pragma once
/*
  MpmSolid - the shape of a rigid thing at rest: half-space, box, sphere, cylinder, cone, polygon, triangulated
  surface, terrain, or one from outside the tree, with the distance from its surface.

  Order of calls: MpmSolidRead(), MpmSolidDistance(), MpmSolidDestroy().
*/
#include "base/types.h"
#include "geometry/surface.h"

typedef enum {
  MPM_SOLID_PLANE,
  MPM_SOLID_BOX,
  MPM_SOLID_SPHERE,
  MPM_SOLID_CYLINDER,
  MPM_SOLID_CONE,
  MPM_SOLID_POLYGON,
  MPM_SOLID_STL,
  MPM_SOLID_TERRAIN,
  MPM_SOLID_ADDED /* from outside the tree (talus/contact.h) */
} MpmSolidType;

typedef struct _p_MpmTriangles *MpmTriangles;
typedef struct MpmAddedBody     MpmAddedBody; /* solid_types.h */

typedef struct {
  MpmSolidType  type;
  PetscInt      dim;
  PetscReal     side;                                /* 1: the material is outside, -1: inside */
  PetscReal     point[MPM_MAX_DIM];                  /* centre; of a plane or an axis; a cone's tip */
  PetscReal     direction[MPM_MAX_DIM];              /* a plane's normal, an axis; a cone's from its tip */
  PetscReal     half[MPM_MAX_DIM], radius, slope[2]; /* of a box; slope: sine and cosine of a cone's half angle */
  PetscInt      vertex_count;
  PetscReal    *vertices; /* x and y, counterclockwise */
  MpmTriangles  triangles;
  MpmBed       *bed; /* of a terrain; read by its boundary */
  MpmAddedBody *added;
} MpmSolid;

extern const char *const MpmSolidTypes[]; /* names of the built-in types */

/*
  Reads -<prefix>type, side, and the options of the type; see solid.c. Of a type from outside the tree, the boundary
  reads the parameters. Collective.
*/
PetscErrorCode MpmSolidRead(const MpmOptions *block, PetscInt dim, MpmSolid *solid);
PetscErrorCode MpmSolidDestroy(MpmSolid *solid);
/* A length of its order, m: a radius, half a diagonal; 1 where it has none. */
PetscReal MpmSolidSize(const MpmSolid *solid);
/* Its point, centre or tip; the centroid of a polygon or of the volume that triangles enclose. */
void MpmSolidMiddle(const MpmSolid *solid, PetscReal middle[MPM_MAX_DIM]);
/* True where its radius can grow. */
PetscBool MpmSolidIsRound(const MpmSolid *solid);
/* At a place x, with the radius grown by this much. On edges and axes, where the gradient jumps: that of one side. */
void MpmSolidDistance(const MpmSolid *solid, PetscReal growth, const PetscReal x[], MpmSurface *surface);
/* True where it consists of flat faces. */
PetscBool MpmSolidHasFaces(const MpmSolid *solid);
