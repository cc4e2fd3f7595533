/*
  The true surface of a body in the boxes of its lattice.

  In a box that has the part B of the body, with B's areas A_f on the box's own sides, the area vector of the surface
  within the box and its first moments follow from the divergence theorem,

    a_j = - sum_f A_f n_fj ,    int x_i n_j = |B| delta_ij - sum_f A_f x_fi n_fj ,

  and are those of every kind of region of which a part of a box is known (geometry/region_part.c). A_f is the volume in
  a thin slice, over its thickness. A side has surface of its own where its two slices, within and beyond, differ.

  Boxes are divided until the sum of |a| stays, and a plane of this size goes through the box: then the surface is
  nearly flat, and lies at int x n . a/|a|^2. Its size is extrapolated, |a| being less by a square of the box's length.
  Sides of the parts lie on no surface that was drawn along the lattice, or half-way.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/points.h"
#include "facets/outer_faces.h"
#include "loads/edge_pieces.h"

#define THIN    1e-6   /* of a box: a slice */
#define NONE    1e-5   /* of a side of a box: an area that is none */
#define FLAT    5e-3   /* of an area: more in the parts, where it is bent */
#define THROUGH 2e-2   /* of a plane's area in a box: less, where it ends there */
#define EVEN    1e-4   /* likewise, where the region ends there */
#define DEPTH_2 6      /* most divisions of a box in 2D */
#define DEPTH_3 2      /* in 3D */
#define DIVIDE  0.4873 /* where a box is divided */
#define BEYOND  1e-3   /* of a box, from a surface */
#define CORNERS 4      /* most pieces within a box, by the way they face */
#define LIKE    0.9    /* cosine of the angle between parts of one piece */
#define SAMPLES 16     /* places along a line */
#define TURN    0.55   /* of lines in a plane */
#define HALVES  40     /* from one of them to the next */

/* ---- the part of a flat piece in a region ---- */

static PetscBool Within(MpmRegion region, PetscInt dim, const PetscReal x[], const PetscReal u[], PetscReal s)
{
  PetscReal at[MPM_MAX_DIM] = {0., 0., 0.};

  for (PetscInt a = 0; a < dim; a++) at[a] = x[a] + s * u[a];
  return MpmRegionContains(region, at);
}

/* Length of the line x + s u, |s| <= 1, in the region, over that of the line, and its first moment by s. */
static PetscReal LinePart(MpmRegion region, PetscInt dim, const PetscReal x[], const PetscReal u[], PetscReal *moment)
{
  PetscBool was    = Within(region, dim, x, u, -1.);
  PetscReal length = 0., from = -1.;

  *moment = 0.;
  for (PetscInt k = 1; k <= SAMPLES; k++) {
    PetscReal       low = -1. + 2. * (PetscReal)(k - 1) / SAMPLES, high = -1. + 2. * (PetscReal)k / SAMPLES;
    const PetscBool is = Within(region, dim, x, u, high);

    for (PetscInt n = 0; n < HALVES && is != was; n++) {
      const PetscReal middle = 0.5 * (low + high);

      if (Within(region, dim, x, u, middle) == was) low = middle;
      else high = middle;
    }
    if (was && (!is || k == SAMPLES)) {
      length += 0.5 * (high - from);
      *moment += 0.25 * (high * high - from * from);
    }
    if (is && !was) from = high;
    if (is && !was && k == SAMPLES) {
      length += 0.5 * (1. - from);
      *moment += 0.25 * (1. - from * from);
    }
    was = is;
  }
  return length;
}

PetscReal MpmFlatPart(MpmRegion region, PetscInt dim, const PetscReal u[], const PetscReal v[], PetscReal x[])
{
  const PetscInt lines = dim == MPM_MAX_DIM ? SAMPLES : 1;
  PetscReal      part = 0., moment[2] = {0., 0.};

  if (!region) return 1.;
  for (PetscInt k = 0; k < lines; k++) {
    const PetscReal t                 = lines > 1 ? (2. * (PetscReal)k + 1.) / (PetscReal)lines - 1. : 0.;
    PetscReal       from[MPM_MAX_DIM] = {0., 0., 0.}, along, length;

    for (PetscInt a = 0; a < dim; a++) from[a] = x[a] + (lines > 1 ? t * v[a] : 0.);
    length = LinePart(region, dim, from, u, &along);
    part += length / (PetscReal)lines;
    moment[0] += along / (PetscReal)lines;
    moment[1] += t * length / (PetscReal)lines;
  }
  for (PetscInt a = 0; a < dim && part > 0.; a++)
    x[a] += moment[0] / part * u[a] + (lines > 1 ? moment[1] / part * v[a] : 0.);
  return part;
}

/* ---- surface in a box ---- */

/* Of a box: its surface within, and what its sides have. */
typedef struct {
  PetscReal low[MPM_MAX_DIM], high[MPM_MAX_DIM];
  PetscReal area[MPM_MAX_DIM], size, place[MPM_MAX_DIM];
} Box;

/* Whose surface, and the sum of its sizes. */
typedef struct {
  const MpmEdgeAsked *of;
  MpmBody             body;
  MpmRegion           region;
  PetscInt            dim;
  const MpmGrid      *grid;  /* where the body was drawn */
  PetscReal          *drawn; /* sum of sizes, in the region or not */
} Asked;

/* Area of the body in a slice of a box along an axis, and its centroid. */
static PetscReal Slice(const Asked *asked, const PetscReal low[], const PetscReal high[], PetscInt axis, PetscReal from,
                       PetscReal to, PetscReal x[])
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < asked->dim; a++) {
    lower[a] = a == axis ? from : low[a];
    upper[a] = a == axis ? to : high[a];
    x[a]     = 0.5 * (lower[a] + upper[a]);
  }
  return MpmBodyPart(asked->body, asked->dim, lower, upper, x) / (to - from);
}

/* On a side of a box, within it or beyond. */
static PetscReal SideArea(const Asked *asked, const PetscReal low[], const PetscReal high[], PetscInt face,
                          PetscBool beyond, PetscReal x[])
{
  const PetscInt  axis = face / 2;
  const PetscReal at = face % 2 ? high[axis] : low[axis], thin = THIN * (high[axis] - low[axis]);
  const PetscReal area = Slice(asked, low, high, axis, (face % 2 ? !beyond : beyond) ? at - thin : at,
                               (face % 2 ? !beyond : beyond) ? at : at + thin, x);

  x[axis] = at;
  return area;
}

/* area, size and place of a box's surface within. */
static void FindWithin(const Asked *asked, Box *box)
{
  const PetscInt dim       = asked->dim;
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.}, moment[MPM_MAX_DIM][MPM_MAX_DIM] = {{0.}}, middle[MPM_MAX_DIM], square = 0.,
            full         = 1.;
  const PetscReal volume = MpmBodyPart(asked->body, dim, box->low, box->high, x);

  box->size = 0.;
  for (PetscInt a = 0; a < dim; a++) {
    middle[a]     = 0.5 * (box->low[a] + box->high[a]);
    box->area[a]  = 0.;
    box->place[a] = middle[a];
    moment[a][a]  = volume;
    full *= box->high[a] - box->low[a];
  }
  if (volume <= 0. || volume >= full) return;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    const PetscReal area = (face % 2 ? 1. : -1.) * SideArea(asked, box->low, box->high, face, PETSC_FALSE, x);

    box->area[face / 2] -= area;
    for (PetscInt a = 0; a < dim && area != 0.; a++) moment[a][face / 2] -= area * (x[a] - middle[a]);
  }
  for (PetscInt a = 0; a < dim; a++) square += PetscSqr(box->area[a]);
  box->size = PetscSqrtReal(square);
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim && square > 0.; b++) box->place[a] += moment[a][b] * box->area[b] / square;
  }
}

/* Directions along a plane of the normal n; in 2D one. In 3D they are turned, not to be along edges of regions. */
static void AlongPlane(PetscInt dim, const PetscReal n[], PetscReal u[], PetscReal v[])
{
  const PetscReal turn[2] = {PetscCosReal(TURN), PetscSinReal(TURN)};
  PetscInt        least   = 0;
  PetscReal       across;

  for (PetscInt a = 1; a < dim; a++)
    if (PetscAbsReal(n[a]) < PetscAbsReal(n[least])) least = a;
  across = PetscSqrtReal(1. - n[least] * n[least]);
  for (PetscInt a = 0; a < dim; a++) u[a] = ((a == least ? 1. : 0.) - n[least] * n[a]) / across;
  for (PetscInt a = 0; a < dim; a++)
    v[a] = dim == MPM_MAX_DIM ? n[(a + 1) % 3] * u[(a + 2) % 3] - n[(a + 2) % 3] * u[(a + 1) % 3] : 0.;
  for (PetscInt a = 0; a < dim && dim == MPM_MAX_DIM; a++) {
    const PetscReal was = u[a];

    u[a] = turn[0] * was + turn[1] * v[a];
    v[a] = turn[0] * v[a] - turn[1] * was;
  }
}

/* Half the length of the line from x along u in a box, and its middle in place of x; 0 where it passes the box. */
static PetscReal LineInBox(const Box *box, PetscInt dim, const PetscReal u[], PetscReal x[])
{
  PetscReal from = PETSC_NINFINITY, to = PETSC_INFINITY;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal low = box->low[a] - x[a], high = box->high[a] - x[a];

    if (PetscAbsReal(u[a]) < THIN) {
      if (low > 0. || high < 0.) return 0.;
      continue;
    }
    from = PetscMax(from, PetscMin(low / u[a], high / u[a]));
    to   = PetscMin(to, PetscMax(low / u[a], high / u[a]));
  }
  if (!(from < to)) return 0.;
  for (PetscInt a = 0; a < dim; a++) x[a] += 0.5 * (from + to) * u[a];
  return 0.5 * (to - from);
}

/* Part in the region of a plane's piece in a box, by lines in it, and the part's middle in place of a place x on it;
   `plane`: area of the piece. */
static PetscReal PartInRegion(const Asked *asked, const Box *box, PetscReal x[], PetscReal *plane)
{
  const PetscInt dim = asked->dim, lines = dim == MPM_MAX_DIM ? 2 * SAMPLES : 1;
  PetscReal n[MPM_MAX_DIM] = {0.}, u[MPM_MAX_DIM], v[MPM_MAX_DIM], sum[MPM_MAX_DIM] = {0., 0., 0.}, all = 0., in = 0.,
            reach[2] = {0., 0.};

  for (PetscInt a = 0; a < dim; a++) n[a] = box->area[a] / box->size;
  AlongPlane(dim, n, u, v);
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt k = 0; k < 2; k++)
      reach[k] += v[a] * ((v[a] > 0. ? k : !k) ? box->high[a] - x[a] : box->low[a] - x[a]);
  for (PetscInt k = 0; k < lines; k++) {
    const PetscReal t               = reach[0] + ((PetscReal)k + 0.5) / (PetscReal)lines * (reach[1] - reach[0]);
    PetscReal       at[MPM_MAX_DIM] = {0., 0., 0.}, part = 1., moment = 0., half, along[MPM_MAX_DIM] = {0., 0., 0.};

    for (PetscInt a = 0; a < dim; a++) at[a] = x[a] + t * v[a];
    half = LineInBox(box, dim, u, at);
    if (!(half > 0.)) continue;
    for (PetscInt a = 0; a < dim; a++) along[a] = half * u[a];
    if (asked->region) part = LinePart(asked->region, dim, at, along, &moment);
    all += half;
    in += half * part;
    for (PetscInt a = 0; a < dim; a++) sum[a] += half * (part * at[a] + moment * along[a]);
  }
  *plane = 2. * all * (lines > 1 ? (reach[1] - reach[0]) / (PetscReal)lines : 1.);
  for (PetscInt a = 0; a < dim && in > 0. && asked->region; a++) x[a] = sum[a] / in;
  return !asked->region ? 1. : all > 0. ? in / all : 0.;
}

/* Adds a box's surface, nearly flat, of this size, as far as it is in the region. */
static void AddFlat(const Asked *asked, const Box *box, PetscReal size, MpmEdgePiece *piece)
{
  const PetscInt dim            = asked->dim;
  PetscReal      x[MPM_MAX_DIM] = {0., 0., 0.}, part, plane;

  for (PetscInt a = 0; a < dim; a++) x[a] = box->place[a];
  part = PartInRegion(asked, box, x, &plane);
  if (asked->of->all_or_none) part = part < 0.5 ? 0. : 1.;
  for (PetscInt a = 0; a < dim; a++) {
    piece->area[a] += part * box->area[a];
    piece->onto[2 * a + (box->area[a] > 0. ? 1 : 0)] += part * PetscAbsReal(box->area[a]);
    piece->place[a] += part * size * x[a]; /* over the sum of sizes at last */
  }
  piece->size += part * size;
  *asked->drawn += size;
}

/* The first other body that was drawn beyond a box's surface, or -1. */
static PetscInt BodyBehind(const Asked *asked, const Box *box)
{
  MpmBodyLattice lattice;
  PetscReal      square = 0., x[MPM_MAX_DIM] = {0., 0., 0.};

  MpmBodyGetLattice(asked->body, &lattice);
  for (PetscInt a = 0; a < asked->dim; a++) square += PetscSqr(box->area[a]);
  for (PetscInt a = 0; a < asked->dim; a++)
    x[a] = box->place[a] + BEYOND * lattice.spacing[a] * box->area[a] / PetscSqrtReal(square);
  for (PetscInt b = 0; b < asked->of->bodies->count; b++)
    if (b != asked->of->body && MpmBodyReaches(asked->of->bodies->at[b], x)) return b;
  return -1;
}

/* The piece of a box that faces as another's surface does, or the first empty one, or the last. */
static MpmEdgePiece *Like(const Asked *asked, const Box *box, MpmEdgePiece pieces[])
{
  const PetscInt dim = asked->dim, behind = BodyBehind(asked, box);

  for (PetscInt k = 0; k < CORNERS - 1; k++) {
    PetscReal along = 0., square = 0.;

    for (PetscInt a = 0; a < dim; a++) {
      along += pieces[k].area[a] * box->area[a];
      square += PetscSqr(pieces[k].area[a]);
    }
    if (!(pieces[k].size > 0.)) pieces[k].behind = behind;
    if (pieces[k].behind != behind) continue;
    if (!(pieces[k].size > 0.) || along > LIKE * box->size * PetscSqrtReal(square)) return &pieces[k];
  }
  pieces[CORNERS - 1].behind = behind;
  return &pieces[CORNERS - 1];
}

/* True where a box's surface, of this size by parts, is a plane that goes through all of the box; or nearly so, if it
   lies in the region or not. */
static PetscBool IsFlat(const Asked *asked, const Box *box, PetscReal sum)
{
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.}, part, plane;

  if (!(box->size > 0.)) return (PetscBool) !(sum > 0.);
  for (PetscInt a = 0; a < asked->dim; a++) x[a] = box->place[a];
  part = PartInRegion(asked, box, x, &plane);
  return (PetscBool)(sum - box->size <= (part > 0. && part < 1. ? EVEN : FLAT) * sum &&
                     PetscAbsReal(plane - box->size) <= THROUGH * plane);
}

/* Adds the surface within a box, of which `box` has the sum, to CORNERS pieces; divides it `depth` times at most. */
static void AddBox(const Asked *asked, const Box *box, PetscInt depth, MpmEdgePiece pieces[])
{
  const PetscInt parts = 1 << asked->dim;
  Box            part[1 << MPM_MAX_DIM];
  PetscReal      sum = 0., side = 1.;

  for (PetscInt a = 1; a < asked->dim; a++) side *= box->high[a] - box->low[a];
  for (PetscInt k = 0; k < parts && depth; k++) {
    for (PetscInt a = 0; a < asked->dim; a++) {
      const PetscReal middle = box->low[a] + DIVIDE * (box->high[a] - box->low[a]);

      part[k].low[a]  = k >> a & 1 ? middle : box->low[a];
      part[k].high[a] = k >> a & 1 ? box->high[a] : middle;
    }
    FindWithin(asked, &part[k]);
    sum += part[k].size;
  }
  if (!depth || IsFlat(asked, box, sum)) {
    if (box->size > NONE * side)
      AddFlat(asked, box, depth ? (4. * sum - box->size) / 3. : box->size, Like(asked, box, pieces));
    return;
  }
  for (PetscInt k = 0; k < parts; k++) AddBox(asked, &part[k], depth - 1, pieces);
}

/* ---- pieces of a point ---- */

static PetscErrorCode Keep(const MpmEdgePiece *piece, PetscInt dim, MpmEdgePieces *pieces)
{
  PetscFunctionBeginUser;
  if (!(piece->size > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  if (pieces->pieces == pieces->room) {
    pieces->room = 2 * pieces->room + 64;
    PetscCall(PetscRealloc((size_t)pieces->room * sizeof(MpmEdgePiece), &pieces->at));
  }
  pieces->at[pieces->pieces] = *piece;
  for (PetscInt a = 0; a < dim; a++) pieces->at[pieces->pieces].place[a] /= piece->size;
  pieces->pieces++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where no point stands in the middle of the box beyond a side: what is there belongs to points aside. */
static PetscBool IsCutBeyond(const Asked *asked, const PetscInt at[], const Box *box, PetscInt face)
{
  const PetscInt axis = face / 2, way = face % 2 ? 1 : -1;
  PetscInt       beyond[MPM_MAX_DIM], boxes[MPM_BODY_BOXES][MPM_MAX_DIM];
  PetscReal      low[MPM_MAX_DIM], high[MPM_MAX_DIM], x[MPM_MAX_DIM], full = 1.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscReal move = a == axis ? (PetscReal)way * (box->high[a] - box->low[a]) : 0.;

    beyond[a] = at[a] + (a == axis ? way : 0);
    if (a >= asked->dim) continue;
    low[a]  = box->low[a] + move;
    high[a] = box->high[a] + move;
    full *= high[a] - low[a];
  }
  if (MpmBodyPart(asked->body, asked->dim, low, high, x) < (1. - NONE) * full) return PETSC_TRUE;
  return (PetscBool)(MpmBodyBoxes(asked->body, asked->grid, beyond, boxes) > 1);
}

/* Adds the part of a box's side that has material on both sides. */
static PetscErrorCode AddInner(const Asked *asked, PetscInt face, PetscReal area, const PetscReal place[],
                               MpmEdgePieces *pieces)
{
  MpmEdgePiece piece = {.behind = -1, .side = face, .inner = PETSC_TRUE, .size = area};

  PetscFunctionBeginUser;
  piece.area[face / 2] = (face % 2 ? 1. : -1.) * area;
  for (PetscInt a = 0; a < asked->dim; a++) piece.place[a] = area * place[a];
  PetscCall(Keep(&piece, asked->dim, pieces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A side of a box, as a box. */
static void SetSide(PetscInt dim, const Box *box, PetscInt face, PetscReal area, const PetscReal place[], Box *side)
{
  *side               = *box;
  side->low[face / 2] = side->high[face / 2] = face % 2 ? box->high[face / 2] : box->low[face / 2];
  side->size                                 = area;
  for (PetscInt a = 0; a < dim; a++) {
    side->area[a]  = a == face / 2 ? (face % 2 ? area : -area) : 0.;
    side->place[a] = place[a];
  }
}

/* Adds those of a box to a point's. */
static PetscErrorCode AddPieces(const Asked *asked, const PetscInt at[], Box *box, MpmEdgePieces *pieces,
                                MpmEdgePoint *point)
{
  const PetscInt dim            = asked->dim;
  MpmEdgePiece   inner[CORNERS] = {{.side = -1}, {.side = -1}, {.side = -1}, {.side = -1}};
  PetscReal      sides;

  PetscFunctionBeginUser;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    MpmEdgePiece    piece               = {.side = face};
    PetscReal       within[MPM_MAX_DIM] = {0.}, beyond[MPM_MAX_DIM] = {0.}, full = 1.;
    Box             side;
    const PetscReal in  = SideArea(asked, box->low, box->high, face, PETSC_FALSE, within),
                    out = SideArea(asked, box->low, box->high, face, PETSC_TRUE, beyond);

    for (PetscInt a = 0; a < dim; a++) full *= a == face / 2 ? 1. : box->high[a] - box->low[a];
    if (PetscAbsReal(in - full) > NONE * full || (out > NONE * full && out < in - NONE * full))
      point->whole = PETSC_FALSE;
    if (out > NONE * full && IsCutBeyond(asked, at, box, face)) point->given |= MpmFaceBit(face / 2, face % 2);
    if (PetscMin(in, out) > NONE * full) PetscCall(AddInner(asked, face, PetscMin(in, out), beyond, pieces));
    if (!(in - out > NONE * full)) continue;
    for (PetscInt a = 0; a < dim; a++) within[a] = (in * within[a] - out * beyond[a]) / (in - out);
    SetSide(asked->dim, box, face, in - out, within, &side);
    piece.behind = BodyBehind(asked, &side);
    AddFlat(asked, &side, in - out, &piece);
    PetscCall(Keep(&piece, dim, pieces));
  }
  sides = *asked->drawn;
  FindWithin(asked, box);
  AddBox(asked, box, dim == MPM_MAX_DIM ? DEPTH_3 : DEPTH_2, inner);
  if (*asked->drawn > sides) point->whole = PETSC_FALSE;
  for (PetscInt k = 0; k < CORNERS; k++) PetscCall(Keep(&inner[k], dim, pieces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindPieces(const Asked *asked, const MpmPoints *points, PetscInt p, MpmEdgePieces *pieces,
                                 MpmEdgePoint *point)
{
  const PetscInt dim = asked->dim;
  MpmBodyLattice lattice;
  PetscInt       at[MPM_MAX_DIM] = {0, 0, 0}, boxes[MPM_BODY_BOXES][MPM_MAX_DIM], count;

  PetscFunctionBeginUser;
  MpmBodyGetLattice(asked->body, &lattice);
  for (PetscInt a = 0; a < dim; a++)
    at[a] = (PetscInt)PetscFloorReal((points->origin[p * dim + a] - lattice.lower[a]) / lattice.spacing[a]);
  count  = MpmBodyBoxes(asked->body, asked->grid, at, boxes);
  *point = (MpmEdgePoint){.id = points->id[p], .first = pieces->pieces, .whole = (PetscBool)(count == 1)};
  for (PetscInt k = 0; k < count; k++) {
    Box box;

    for (PetscInt a = 0; a < dim; a++) {
      box.low[a]  = lattice.lower[a] + lattice.spacing[a] * (PetscReal)boxes[k][a];
      box.high[a] = lattice.lower[a] + lattice.spacing[a] * (PetscReal)(boxes[k][a] + 1);
    }
    PetscCall(AddPieces(asked, boxes[k], &box, pieces, point));
  }
  point->count = pieces->pieces - point->first;
  point->size  = *asked->drawn;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- table ---- */

/* Where the point stands in the table, or the gap for it. */
static MpmEdgePoint *Find(const MpmEdgePieces *pieces, PetscInt id)
{
  PetscInt k = id % pieces->capacity;

  while (pieces->point[k].id >= 0 && pieces->point[k].id != id) k = (k + 1) % pieces->capacity;
  return &pieces->point[k];
}

static PetscErrorCode Grow(MpmEdgePieces *pieces)
{
  MpmEdgePieces old = *pieces;

  PetscFunctionBeginUser;
  if (2 * pieces->points < pieces->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  pieces->capacity = 4 * old.capacity + 64;
  PetscCall(PetscMalloc1(pieces->capacity, &pieces->point));
  for (PetscInt k = 0; k < pieces->capacity; k++) pieces->point[k].id = -1;
  for (PetscInt k = 0; k < old.capacity; k++)
    if (old.point[k].id >= 0) *Find(pieces, old.point[k].id) = old.point[k];
  PetscCall(PetscFree(old.point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEdgePiecesGet(MpmEdgePieces *pieces, const MpmEdgeAsked *of, const MpmGrid *grid,
                                const MpmPoints *points, PetscInt p, const MpmEdgePoint **point)
{
  MpmGrid       start = *grid;
  PetscReal     drawn = 0.;
  const Asked   asked = {of, of->bodies->at[of->body], of->region, grid->dim, &start, &drawn};
  MpmEdgePoint *there;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < grid->dim; a++) {
    start.lower[a] = grid->start_lower[a];
    start.upper[a] = grid->start_upper[a];
    start.h[a]     = grid->start_h[a];
  }
  PetscCall(Grow(pieces));
  there = Find(pieces, points->id[p]);
  if (there->id < 0) {
    PetscCall(FindPieces(&asked, points, p, pieces, there));
    pieces->points++;
  }
  *point = there;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEdgePiecesDestroy(MpmEdgePieces *pieces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(pieces->point));
  PetscCall(PetscFree(pieces->at));
  *pieces = (MpmEdgePieces){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}
