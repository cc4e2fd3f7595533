/*
  Edges of polygons that cross, by a sweep along x: edges are compared where their ranges of x overlap.
*/
#include "maps/map.h"
#include "maps/outline_build.h"

typedef struct {
  const PetscReal *a, *b; /* ends */
  PetscReal        left, right;
} Edge;

static int ByLeft(const void *one, const void *other)
{
  const PetscReal a = ((const Edge *)one)->left, b = ((const Edge *)other)->left;

  return (a > b) - (a < b);
}

/* Twice the area of a triangle, and 0 where that is of the size of rounding. */
static int Side(const PetscReal a[], const PetscReal b[], const PetscReal c[])
{
  const PetscReal one = (b[0] - a[0]) * (c[1] - a[1]), other = (b[1] - a[1]) * (c[0] - a[0]);
  const PetscReal slack = 1e-12 * (PetscAbsReal(one) + PetscAbsReal(other));

  return (one - other > slack) - (one - other < -slack);
}

/* True where two edges cross within both. */
static PetscBool Cross(const Edge *one, const Edge *other)
{
  return (PetscBool)(Side(one->a, one->b, other->a) * Side(one->a, one->b, other->b) < 0 &&
                     Side(other->a, other->b, one->a) * Side(other->a, other->b, one->b) < 0);
}

/* The edges of all polygons; returns their number. */
static PetscInt Edges(const MpmOutline *outline, Edge edge[])
{
  PetscInt n = 0;

  for (PetscInt f = 0; f < outline->features; f++) {
    for (PetscInt k = outline->feature[f].first; k < outline->feature[f].end; k++) {
      const PetscInt   count = outline->start[k + 1] - outline->start[k];
      const PetscReal *at    = &outline->at[2 * outline->start[k]];

      for (PetscInt i = 0; outline->feature[f].type == MPM_OUTLINE_POLYGON && i < count; i++) {
        const PetscReal *a = &at[2 * i], *b = &at[2 * ((i + 1) % count)];

        edge[n++] = (Edge){a, b, PetscMin(a[0], b[0]), PetscMax(a[0], b[0])};
      }
    }
  }
  return n;
}

PetscErrorCode MpmOutlineCheck(const MpmOutline *outline, char message[])
{
  Edge    *edge;
  PetscInt count;

  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < 2 * outline->start[outline->paths]; v++)
    if (PetscIsInfOrNanReal(outline->at[v])) (void)snprintf(message, MPM_MAP_MESSAGE, "has a place that is no number");
  PetscCall(PetscMalloc1(outline->start[outline->paths], &edge));
  count = Edges(outline, edge);
  qsort(edge, (size_t)count, sizeof(*edge), ByLeft);
  for (PetscInt i = 0; i < count && !message[0]; i++) {
    for (PetscInt j = i + 1; j < count && edge[j].left <= edge[i].right && !message[0]; j++) {
      if (Cross(&edge[i], &edge[j]))
        (void)snprintf(message, MPM_MAP_MESSAGE, "has edges that cross, from (%.10g, %.10g) and from (%.10g, %.10g)",
                       (double)edge[i].a[0], (double)edge[i].a[1], (double)edge[j].a[0], (double)edge[j].a[1]);
    }
  }
  PetscCall(PetscFree(edge));
  PetscFunctionReturn(PETSC_SUCCESS);
}
