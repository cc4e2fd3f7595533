/*
  Makes a surface of loose triangles: finds their vertices, their neighbours and their faults.
*/
#include "geometry/triangles_impl.h"

#include <math.h>
#include <stdlib.h>

#define THIN 1e-12 /* twice the area of a triangle over the square of its longest edge, at least */

/* Collects messages about a surface; the first one stays. */
#define COMPLAIN(...) PetscCall(PetscSNPrintf(message, MPM_TRIANGLES_MESSAGE, __VA_ARGS__))

#define PLACE_TEXT (3 * MPM_NUMBER_TEXT + 8)
static void PlaceText(const PetscReal x[], char text[PLACE_TEXT])
{
  char number[3][MPM_NUMBER_TEXT];

  for (PetscInt a = 0; a < 3; a++) MpmRealText(x[a], number[a]);
  (void)PetscSNPrintf(text, PLACE_TEXT, "(%s, %s, %s)", number[0], number[1], number[2]);
}

/* ---- vertices ---- */

typedef struct {
  PetscReal x[3];
  PetscInt  half;
} Loose;

static int CompareLoose(const void *a, const void *b)
{
  const Loose *p = (const Loose *)a, *q = (const Loose *)b;

  for (int k = 0; k < 3; k++)
    if (p->x[k] != q->x[k]) return p->x[k] < q->x[k] ? -1 : 1;
  return (p->half > q->half) - (p->half < q->half);
}

/* Corners at one place are one vertex. */
static PetscErrorCode FindVertices(MpmTriangles triangles, const PetscReal corners[])
{
  const PetscInt halves = 3 * triangles->count;
  Loose         *loose;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(halves, &loose));
  for (PetscInt half = 0; half < halves; half++) {
    loose[half].half = half;
    for (PetscInt a = 0; a < 3; a++) loose[half].x[a] = corners[3 * (PetscInt64)half + a];
  }
  qsort(loose, (size_t)halves, sizeof(*loose), CompareLoose);
  PetscCall(PetscMalloc1(3 * (size_t)halves, &triangles->vertex));
  for (PetscInt k = 0; k < halves; k++) {
    PetscReal *last = &triangles->vertex[3 * (PetscInt64)(triangles->vertex_count - 1)];

    if (!k || loose[k].x[0] != last[0] || loose[k].x[1] != last[1] || loose[k].x[2] != last[2]) {
      last = &triangles->vertex[3 * (PetscInt64)triangles->vertex_count++];
      for (PetscInt a = 0; a < 3; a++) last[a] = loose[k].x[a];
    }
    triangles->corner[loose[k].half] = triangles->vertex_count - 1;
  }
  PetscCall(PetscFree(loose));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetNormals(MpmTriangles triangles, char message[])
{
  char text[PLACE_TEXT];

  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < triangles->count && !message[0]; t++) {
    PetscReal edge[3][3], longest = 0., length, *normal = &triangles->normal[3 * t];

    for (PetscInt k = 0; k < 3; k++) {
      MpmTrianglesEdge(triangles, 3 * t + k, edge[k]);
      longest = PetscMax(longest, MpmDot3(edge[k], edge[k]));
    }
    MpmCross3(edge[0], edge[1], normal);
    length = MpmNorm3(normal);
    for (PetscInt a = 0; a < 3; a++) normal[a] /= length;
    if (length > THIN * longest) continue;
    PlaceText(MpmTrianglesCorner(triangles, 3 * t), text);
    COMPLAIN("triangle %" PetscInt_FMT ", at %s, has no area", t + 1, text);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- edges ---- */

typedef struct {
  PetscInt low, high, half; /* vertices, half-edge */
} Side;

static int CompareSides(const void *a, const void *b)
{
  const Side *p = (const Side *)a, *q = (const Side *)b;

  if (p->low != q->low) return p->low < q->low ? -1 : 1;
  if (p->high != q->high) return p->high < q->high ? -1 : 1;
  return (p->half > q->half) - (p->half < q->half);
}

/* Message about an edge that is not of two triangles in opposite directions. */
static PetscErrorCode ComplainOfEdge(MpmTriangles triangles, const Side side[], PetscInt count, char message[])
{
  const PetscInt one = side[0].half / 3 + 1, other = side[count > 1].half / 3 + 1;
  char           from[PLACE_TEXT], to[PLACE_TEXT];

  PetscFunctionBeginUser;
  PlaceText(&triangles->vertex[3 * side->low], from);
  PlaceText(&triangles->vertex[3 * side->high], to);
  if (count == 1)
    COMPLAIN("the surface is open: the edge from %s to %s belongs to triangle %" PetscInt_FMT " alone", from, to, one);
  else if (count == 2)
    COMPLAIN("triangles %" PetscInt_FMT " and %" PetscInt_FMT
             " disagree about the outside: both pass the edge from %s to %s in the same direction, so one is inverted",
             one, other, from, to);
  else
    COMPLAIN("the edge from %s to %s belongs to %" PetscInt_FMT " triangles, %" PetscInt_FMT " and %" PetscInt_FMT
             " among them, where a surface has two",
             from, to, count, one, other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Neighbours. */
static PetscErrorCode FindTwins(MpmTriangles triangles, char message[])
{
  const PetscInt halves = 3 * triangles->count;
  PetscInt       next;
  Side          *side;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(halves, &side));
  for (PetscInt half = 0; half < halves; half++) {
    const PetscInt p = triangles->corner[half], q = triangles->corner[MpmHalfNext(half)];

    side[half] = (Side){PetscMin(p, q), PetscMax(p, q), half};
  }
  qsort(side, (size_t)halves, sizeof(*side), CompareSides);
  for (PetscInt k = 0; k < halves && !message[0]; k = next) {
    for (next = k + 1; next < halves && side[next].low == side[k].low && side[next].high == side[k].high;) next++;
    const PetscInt one = side[k].half, other = side[next - 1].half;

    if (next - k != 2 || triangles->corner[one] == triangles->corner[other])
      PetscCall(ComplainOfEdge(triangles, &side[k], next - k, message));
    triangles->twin[one]   = other;
    triangles->twin[other] = one;
  }
  PetscCall(PetscFree(side));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- vertices, again ---- */

/* The triangles at a vertex must be one fan. */
static PetscErrorCode CheckFans(MpmTriangles triangles, char message[])
{
  PetscInt *left;
  char      text[PLACE_TEXT];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(triangles->vertex_count, &left));
  for (PetscInt half = 0; half < 3 * triangles->count; half++) left[triangles->corner[half]]++;
  for (PetscInt first = 0; first < 3 * triangles->count && !message[0]; first++) {
    const PetscInt v    = triangles->corner[first];
    PetscInt       half = first;

    if (left[v] <= 0) continue; /* has been walked round */
    do {
      left[v]--;
      half = MpmHalfNext(triangles->twin[half]);
    } while (half != first);
    if (!left[v]) continue;
    PlaceText(&triangles->vertex[3 * v], text);
    COMPLAIN("two parts of the surface touch at the vertex %s, of triangle %" PetscInt_FMT, text, first / 3 + 1);
  }
  PetscCall(PetscFree(left));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- parts ---- */

/* Solid angle of a triangle from x over 4 pi, positive from inside (Van Oosterom and Strackee 1983). */
static PetscReal SolidAngle(MpmTriangles triangles, PetscInt t, const PetscReal x[])
{
  PetscReal r[3][3], length[3], cross[3], below;

  for (PetscInt k = 0; k < 3; k++) {
    for (PetscInt a = 0; a < 3; a++) r[k][a] = MpmTrianglesCorner(triangles, 3 * t + k)[a] - x[a];
    length[k] = MpmNorm3(r[k]);
  }
  MpmCross3(r[0], r[1], cross);
  below = length[0] * length[1] * length[2] + MpmDot3(r[0], r[1]) * length[2] + MpmDot3(r[1], r[2]) * length[0] +
          MpmDot3(r[2], r[0]) * length[1];
  return PetscAtan2Real(MpmDot3(cross, r[2]), below) / (2. * PETSC_PI);
}

/*
  The winding number must be one just inside of triangle t and zero just outside: 1/2 about its middle, where t itself
  does not count.
*/
static PetscErrorCode CheckPart(MpmTriangles triangles, PetscInt t, char message[])
{
  PetscReal middle[3] = {0., 0., 0.}, winding = 0.;
  char      text[PLACE_TEXT];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 3; k++)
    for (PetscInt a = 0; a < 3; a++) middle[a] += MpmTrianglesCorner(triangles, 3 * t + k)[a] / 3.;
  for (PetscInt other = 0; other < triangles->count; other++)
    if (other != t) winding += SolidAngle(triangles, other, middle);
  if (PetscAbsReal(winding - 0.5) < 0.25) PetscFunctionReturn(PETSC_SUCCESS);
  PlaceText(MpmTrianglesCorner(triangles, 3 * t), text);
  COMPLAIN(winding < 0.5 ? "the part with triangle %" PetscInt_FMT ", at %s, is inverted: its triangles look inwards"
                         : "the part with triangle %" PetscInt_FMT ", at %s, lies within another part",
           t + 1, text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Area(MpmTriangles triangles, PetscInt t)
{
  PetscReal p[3], q[3], cross[3];

  MpmTrianglesEdge(triangles, 3 * t, p);
  MpmTrianglesEdge(triangles, 3 * t + 1, q);
  MpmCross3(p, q, cross);
  return MpmNorm3(cross);
}

/* Each connected part, by its largest triangle. */
static PetscErrorCode CheckParts(MpmTriangles triangles, char message[])
{
  PetscInt  *stack, depth;
  PetscBool *seen;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(triangles->count, &stack));
  PetscCall(PetscCalloc1(triangles->count, &seen));
  for (PetscInt first = 0; first < triangles->count && !message[0]; first++) {
    PetscInt largest = first;

    if (seen[first]) continue;
    seen[first] = PETSC_TRUE;
    stack[0]    = first;
    depth       = 1;
    while (depth) {
      const PetscInt t = stack[--depth];

      if (Area(triangles, t) > Area(triangles, largest)) largest = t;
      for (PetscInt k = 0; k < 3; k++) {
        const PetscInt other = triangles->twin[3 * t + k] / 3;

        if (seen[other]) continue;
        seen[other]    = PETSC_TRUE;
        stack[depth++] = other;
      }
    }
    PetscCall(CheckPart(triangles, largest, message));
  }
  PetscCall(PetscFree(stack));
  PetscCall(PetscFree(seen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrianglesConnect(MpmTriangles triangles, PetscInt count, const PetscReal corners[], char message[])
{
  PetscFunctionBeginUser;
  triangles->count = count;
  PetscCall(PetscMalloc1(3 * (size_t)count, &triangles->corner));
  PetscCall(PetscMalloc1(3 * (size_t)count, &triangles->twin));
  PetscCall(PetscMalloc1(3 * (size_t)count, &triangles->normal));
  PetscCall(FindVertices(triangles, corners));
  PetscCall(SetNormals(triangles, message));
  if (!message[0]) PetscCall(FindTwins(triangles, message));
  if (!message[0]) PetscCall(CheckFans(triangles, message));
  if (!message[0]) PetscCall(CheckParts(triangles, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}
