/*
  The nearest of many things, by Embree (https://www.embree.org; Wald et al. 2014, doi:10.1145/2601097.2601199).

  Boxes and places are scaled to about 1 and rounded to single precision, boxes outwards. A place is off by its rounding
  then, and its squared distance from a box by a few more in the last digit. The radius of the search is that of the
  best thing so far, enlarged by both.
*/
#include "geometry/nearest.h"

PetscBool MpmNearestSupported(void)
{
#if defined(TALUS_EMBREE)
  return PETSC_TRUE;
#else
  return PETSC_FALSE;
#endif
}

#if defined(TALUS_EMBREE)
#include <math.h>
#include <float.h>
#if TALUS_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#define SMALL 1e-15 /* least radius of a search: its square must not vanish in single precision */

struct _p_MpmNearest {
  RTCDevice  device;
  RTCScene   scene;
  PetscReal  middle[MPM_MAX_DIM], scale; /* scaled: (x - middle) scale */
  PetscReal *boxes;                      /* while the tree is built */
};

/* One search. */
typedef struct {
  MpmNearest       nearest;
  MpmNearestSquare square;
  const void      *ctx;
  const PetscReal *x;
  PetscReal        best, error; /* error: of the rounded place, scaled */
  PetscInt         thing;
} Search;

/* The next number of single precision in this direction, so that no rounding is left. */
static float Outwards(PetscReal value, float direction)
{
  return nextafterf((float)value, direction);
}

static void Bounds(const struct RTCBoundsFunctionArguments *args)
{
  const MpmNearest  nearest = (MpmNearest)args->geometryUserPtr;
  const PetscReal  *box     = &nearest->boxes[6 * (size_t)args->primID];
  struct RTCBounds *bounds  = args->bounds_o;
  float             lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = Outwards((box[a] - nearest->middle[a]) * nearest->scale, -FLT_MAX);
    upper[a] = Outwards((box[3 + a] - nearest->middle[a]) * nearest->scale, FLT_MAX);
  }
  bounds->lower_x = lower[0];
  bounds->lower_y = lower[1];
  bounds->lower_z = lower[2];
  bounds->upper_x = upper[0];
  bounds->upper_y = upper[1];
  bounds->upper_z = upper[2];
}

/* The scale makes the largest coordinate 1. */
static void SetScale(MpmNearest nearest, PetscInt count)
{
  PetscReal size = 0.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscReal lower = PETSC_INFINITY, upper = PETSC_NINFINITY;

    for (PetscInt k = 0; k < count; k++) {
      lower = PetscMin(lower, nearest->boxes[6 * (PetscInt64)k + a]);
      upper = PetscMax(upper, nearest->boxes[6 * (PetscInt64)k + 3 + a]);
    }
    nearest->middle[a] = 0.5 * (lower + upper);
    size               = PetscMax(size, upper - nearest->middle[a]);
  }
  nearest->scale = size > 0. ? 1. / size : 1.;
}

PetscErrorCode MpmNearestCreate(PetscInt count, const PetscReal boxes[], MpmNearest *nearest)
{
  RTCGeometry geometry;
  MpmNearest  made;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&made));
  PetscCall(PetscMalloc1(6 * (size_t)count, &made->boxes));
  PetscCall(PetscArraycpy(made->boxes, boxes, 6 * (size_t)count));
  SetScale(made, count);
  made->device = rtcNewDevice("threads=1,set_affinity=0"); /* ranks share the cores among them */
  PetscCheck(made->device, PETSC_COMM_SELF, PETSC_ERR_LIB, "Embree does not start: error %d",
             (int)rtcGetDeviceError(NULL));
  made->scene = rtcNewScene(made->device);
  rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
  geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, (unsigned int)count);
  rtcSetGeometryUserData(geometry, made);
  rtcSetGeometryBoundsFunction(geometry, Bounds, NULL);
  rtcCommitGeometry(geometry);
  (void)rtcAttachGeometry(made->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(made->scene);
  const enum RTCError error = rtcGetDeviceError(made->device);

  PetscCheck(error == RTC_ERROR_NONE, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "Embree cannot build a tree of %" PetscInt_FMT " boxes: error %d", count, (int)error);
  PetscCall(PetscFree(made->boxes));
  *nearest = made;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNearestDestroy(MpmNearest *nearest)
{
  PetscFunctionBeginUser;
  if (!*nearest) PetscFunctionReturn(PETSC_SUCCESS);
  rtcReleaseScene((*nearest)->scene);
  rtcReleaseDevice((*nearest)->device);
  PetscCall(PetscFree(*nearest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Embree comes by a thing that may be nearer; true: the radius has changed. */
static bool Visit(struct RTCPointQueryFunctionArguments *args)
{
  Search         *search = (Search *)args->userPtr;
  const PetscInt  thing  = (PetscInt)args->primID;
  const PetscReal square = search->square(search->ctx, thing, search->x);

  if (!(square < search->best || (square == search->best && thing < search->thing))) return false;
  search->best  = square;
  search->thing = thing;
  args->query->radius =
    Outwards((PetscSqrtReal(square) * search->nearest->scale + search->error + SMALL) * (1. + 1e-6), FLT_MAX);
  return true;
}

PetscInt MpmNearestFind(MpmNearest nearest, MpmNearestSquare square, const void *ctx, const PetscReal x[MPM_MAX_DIM])
{
  struct RTCPointQueryContext context;
  struct RTCPointQuery        query  = {.time = 0.f, .radius = INFINITY};
  Search                      search = {nearest, square, ctx, x, PETSC_INFINITY, 0., -1};
  float                       at[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscReal place = (x[a] - nearest->middle[a]) * nearest->scale;

    at[a] = (float)place;
    if (!isfinite(at[a])) return -1;
    search.error += PetscAbsReal(place - (PetscReal)at[a]) + PETSC_MACHINE_EPSILON * PetscAbsReal(place);
  }
  query.x = at[0];
  query.y = at[1];
  query.z = at[2];
  rtcInitPointQueryContext(&context);
  (void)rtcPointQuery(nearest->scene, &query, &context, Visit, &search);
  return search.thing;
}
#else
PetscErrorCode MpmNearestCreate(PetscInt count, const PetscReal boxes[], MpmNearest *nearest)
{
  PetscFunctionBeginUser;
  (void)count, (void)boxes, (void)nearest;
  SETERRQ(PETSC_COMM_SELF, PETSC_ERR_SUP_SYS, "built without Embree");
}

PetscErrorCode MpmNearestDestroy(MpmNearest *nearest)
{
  PetscFunctionBeginUser;
  *nearest = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmNearestFind(MpmNearest nearest, MpmNearestSquare square, const void *ctx, const PetscReal x[MPM_MAX_DIM])
{
  (void)nearest, (void)square, (void)ctx, (void)x;
  return -1;
}
#endif
