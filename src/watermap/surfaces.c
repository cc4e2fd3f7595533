/*
  Derivatives of loads on surfaces of bodies, and of water that passes them (loads/surface_load.c, surface_flow.c).

  Along directions of the state, of the solution and of parameters each face of a point has a change of its residual at
  the group's nodes,

    load    - d (w_i force) ,   force = f s a' + f t |a'| ,   a' = cof(dF) a
    water   - d (w_i O + e c . grad phi_i) ,   O = Q . a/V + beta e ,   e = sum_i w_i p_i - p_wanted ,
            c = Q(a/V) - Q(0) at rest ,   beta = - b c . a/V

  with Q(g) the kernel's flux at grad p = g and b constant. Areas are quadratic in F: differences of them over a finite
  change are exact. The transposed operation takes unit directions, of which a face has few: bars are -lam . dr.
*/
#include "point/layout.h"
#include "grid/grid.h"
#include "space/point_shape.h"
#include "facets/facets.h"
#include "facets/outer_faces.h"
#include "loads/body_surface.h"
#include "stepmap/point_along.h"
#include "stepmap/rates_end.h"
#include "watermap/water_map.h"

/* A face with its changes in the directions. */
typedef struct {
  const MpmSurfaceFace *face;
  const MpmGroup       *group;
  PetscInt              n;
  PetscReal             area[MPM_PACK][3], per_area[MPM_PACK][MPM_MAX_DIM]; /* changes */
  const PetscReal      *weight;
  PetscReal            *dweight; /* [j*n + i] */
} Face;

/* Room for all faces. */
typedef struct {
  const MpmStepMap        *map;
  const MpmStepDirections *directions;
  MpmAlongWork             work;
  PetscReal               *dweight, *room;
} Pass;

static PetscErrorCode PassCreate(const MpmStepMap *map, const MpmStepDirections *directions, Pass *pass)
{
  const PetscInt n = PetscPowInt(map->sum->space->width, map->sum->space->dim);

  PetscFunctionBeginUser;
  pass->map        = map;
  pass->directions = directions;
  PetscCall(MpmAlongWorkCreate(map, &pass->work));
  PetscCall(PetscMalloc2((n * MPM_PACK), &pass->dweight, (n * map->sum->block), &pass->room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PassDestroy(Pass *pass)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(pass->dweight, pass->room));
  PetscCall(MpmAlongWorkDestroy(&pass->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- geometry ---- */

/* A factor that brings a change to the size of one; 0 for none. */
static PetscReal Unit(PetscInt count, const PetscReal change[])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < count; k++) most = PetscMax(most, PetscAbsReal(change[k]));
  return most > 0. ? 1. / most : 0.;
}

/* The change of the whole face's area with F, and of the way from the point to it. */
static void OuterAlong(const MpmPoints *points, PetscInt p, PetscInt side, const MpmPointVector *start,
                       PetscReal darm[], PetscReal darea[])
{
  const PetscInt   dim = start->dim, axis = side / 2;
  const PetscReal *F = MpmPointF(points, p), *half = &points->domain.half_length[p * dim];
  const PetscReal *dF     = MpmPointNumbers(start, MPM_VECTOR_F, p);
  const PetscReal *length = MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p);
  const PetscReal  unit   = Unit(dim * dim, dF);
  PetscReal        arm[MPM_MAX_DIM], area[MPM_MAX_DIM], stretch = 0.;

  MpmOuterFace(dim, F, half, axis, side % 2, arm, area);
  for (PetscInt a = 0; length && a < dim; a++) stretch += a == axis ? 0. : length[a];
  for (PetscInt a = 0; a < dim; a++) {
    darm[a]  = length ? arm[a] * length[axis] : 0.;
    darea[a] = area[a] * stretch;
  }
  for (PetscInt s = -1; unit > 0. && s < 2; s += 2) {
    PetscReal G[MPM_F_MAX];

    for (PetscInt k = 0; k < dim * dim; k++) G[k] = F[k] + (PetscReal)s * unit * dF[k];
    MpmOuterFace(dim, G, half, axis, side % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) {
      darm[a] += 0.5 * (PetscReal)s * arm[a] / unit;
      darea[a] += 0.5 * (PetscReal)s * area[a] / unit;
    }
  }
}

/* The face's side of its point, 2 axis + side, and the part of that which it has. */
static PetscInt SideOf(const MpmPoints *points, PetscInt dim, const MpmSurfaceFace *face, PetscReal *part)
{
  PetscInt side = 0;

  *part = 0.;
  for (PetscInt k = 0; k < 2 * dim; k++) {
    PetscReal arm[MPM_MAX_DIM], area[MPM_MAX_DIM] = {0.}, along = 0., square = 0., apart = 0.;

    MpmOuterFace(dim, MpmPointF(points, face->point), &points->domain.half_length[face->point * dim], k / 2, k % 2, arm,
                 area);
    for (PetscInt a = 0; a < dim; a++) {
      along += area[a] * face->area[a];
      square += area[a] * area[a];
      apart += PetscAbsReal(points->x[face->point * dim + a] + arm[a] - face->place[a]);
    }
    if (apart != 0. || !(along > 0.)) continue;
    side  = k;
    *part = along / square;
  }
  return side;
}

/* The changes of areas and weights. */
static PetscErrorCode GeometryAlong(Pass *pass, Face *at)
{
  const MpmStepMap *map    = pass->map;
  const MpmPoints  *points = map->sum->points;
  const MpmSpace   *space  = map->sum->space;
  const PetscInt    p = at->face->point, dim = space->dim, n = at->n;
  const MpmFacet    facet = {
       .point = p, .group = at->face->group, .place = {at->face->place[0], at->face->place[1], at->face->place[2]}};
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH], cofactor[MPM_F_MAX], part;
  const PetscReal J    = MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  const PetscInt  side = SideOf(points, dim, at->face, &part);
  MpmFacetSlopes  slopes;

  PetscFunctionBeginUser;
  MpmFacetLines(map->rules, space, points, &facet, line);
  MpmFacetLineSlopes(map->rules, space, points, &facet, &slopes);
  PetscCall(PetscArrayzero(at->dweight, n * pass->directions->count));
  for (PetscInt j = 0; j < pass->directions->count; j++) {
    const MpmPointVector *start = pass->directions->of[j].start;
    const PetscReal      *dF = MpmPointNumbers(start, MPM_VECTOR_F, p), *dx = &start->x[p * dim];
    PetscReal             darm[MPM_MAX_DIM], volume = MpmPointNumber(start, MPM_VECTOR_VOLUME, p);

    OuterAlong(points, p, side, start, darm, at->area[j]);
    for (PetscInt k = 0; k < dim * dim; k++) volume += cofactor[k] * dF[k] / J;
    for (PetscInt a = 0; a < 3; a++) at->area[j][a] = a < dim ? part * at->area[j][a] : 0.;
    for (PetscInt a = 0; a < dim; a++)
      at->per_area[j][a] = at->area[j][a] / (points->volume0[p] * J) - at->face->per_area[a] * volume;
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal       kept[MPM_MAX_WIDTH];
      const PetscReal half = pass->work.argument[(dim + a) * MPM_PACK + j];

      PetscCall(PetscArraycpy(kept, line[a], MPM_MAX_WIDTH));
      for (PetscInt i = 0; i < at->group->count[a]; i++)
        line[a][i] = slopes.by_place[a][i] * (dx[a] + darm[a]) / map->sum->grid->h[a] +
                     slopes.by_point[a][i] * dx[a] / map->sum->grid->h[a] + slopes.by_length[a][i] * half;
      MpmLinesMultiply(dim, at->group, line, pass->room);
      for (PetscInt i = 0; i < n; i++) at->dweight[j * n + i] += pass->room[i];
      PetscCall(PetscArraycpy(line[a], kept, MPM_MAX_WIDTH));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- loads ---- */

/* cof(I + H) a, H and the result in space */
static void NewArea(const PetscReal H[], const PetscReal a[], PetscReal area[])
{
  PetscReal F[9], cofactor[9];

  for (PetscInt k = 0; k < 9; k++) F[k] = H[k] + (k % 4 ? 0. : 1.);
  (void)MpmCofactors(9, F, cofactor);
  for (PetscInt i = 0; i < 3; i++)
    area[i] = cofactor[3 * i] * a[0] + cofactor[3 * i + 1] * a[1] + cofactor[3 * i + 2] * a[2];
}

static void NewAreaAlong(const PetscReal H[], const PetscReal dH[], const PetscReal a[], const PetscReal da[],
                         PetscReal change[])
{
  const PetscReal unit = Unit(9, dH);

  NewArea(H, da, change);
  for (PetscInt s = -1; unit > 0. && s < 2; s += 2) {
    PetscReal G[9], area[3];

    for (PetscInt k = 0; k < 9; k++) G[k] = H[k] + (PetscReal)s * unit * dH[k];
    NewArea(G, a, area);
    for (PetscInt i = 0; i < 3; i++) change[i] += 0.5 * (PetscReal)s * area[i] / unit;
  }
}

/* The displacement's gradient among a kernel's inputs, each `stride` from the next, in space. */
static void TakeGradient(const Pass *pass, const PetscReal input[], PetscInt stride, PetscReal H[])
{
  const MpmKnown known = pass->work.point.known;

  for (PetscInt k = 0; k < 9; k++) H[k] = 0.;
  for (PetscInt k = 0; k < known.inputs; k++) {
    const PetscInt c = KnownComponent(known, pass->map->sum->layout, k),
                   b = KnownBasis(known, pass->map->sum->layout, k);

    if (c < known.dim && b >= 1 && b <= known.dim) H[3 * c + b - 1] = input[k * stride];
  }
}

static void LoadAlong(Pass *pass, const Face *at)
{
  const MpmSurfaceFaces *faces   = pass->map->surfaces;
  const MpmBodySurface  *surface = &faces->surfaces->at[at->face->surface];
  const PetscReal        factor = faces->factor[at->face->surface], normal = factor * surface->normal;
  const PetscInt         dim = pass->map->sum->space->dim, n = at->n, size = n * pass->map->sum->block;
  PetscReal              H[9], area[3], length                             = 0.;

  if (!surface->loaded || factor == 0.) return;
  TakeGradient(pass, pass->work.point.input, 1, H);
  NewArea(H, at->face->area, area);
  for (PetscInt a = 0; a < 3; a++) length += area[a] * area[a];
  length = PetscSqrtReal(length);
  for (PetscInt j = 0; j < pass->directions->count; j++) {
    PetscReal dH[9], change[3], stretch = 0.;

    TakeGradient(pass, &pass->work.dinput[j], MPM_PACK, dH);
    NewAreaAlong(H, dH, at->face->area, at->area[j], change);
    for (PetscInt a = 0; a < 3; a++) stretch += area[a] * change[a] / length;
    for (PetscInt c = 0; c < dim; c++) {
      const PetscReal force  = normal * area[c] + factor * surface->traction[c] * length;
      const PetscReal dforce = normal * change[c] + factor * surface->traction[c] * stretch;

      for (PetscInt i = 0; i < n; i++)
        pass->work.force[j * size + c * n + i] -= at->dweight[j * n + i] * force + at->weight[i] * dforce;
    }
  }
}

/* ---- water ---- */

/* Q and its changes: rows of MPM_PACK. */
typedef struct {
  PetscReal flux[MPM_MAX_INPUTS], dflux[MPM_MAX_INPUTS * MPM_PACK];
} Flux;

static PetscErrorCode FindFlux(Pass *pass, PetscInt p, const MpmKernelPoint *point, const PetscReal input[],
                               const MpmKernelDirection *direction, Flux *flux)
{
  MpmAlongWork      *work  = &pass->work;
  const MpmKernelEnd slope = {.state = work->state, .own = work->own, .F = work->F, .stress = work->stress};

  PetscFunctionBeginUser;
  PetscCheck(!pass->map->surfaces->kernel->sensitivity(point, input, direction, flux->flux, flux->dflux, &slope),
             PETSC_COMM_SELF, PETSC_ERR_FP, "a face's point has no answer at the solution of its step");
  for (PetscInt j = 0; j < pass->directions->count; j++) /* in proportion to the initial volume */
    for (PetscInt k = 0; k < pass->work.point.known.inputs; k++)
      flux->dflux[k * MPM_PACK + j] +=
        MpmPointNumber(pass->directions->of[j].start, MPM_VECTOR_VOLUME, p) * flux->flux[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* c and its changes: the flux of grad p = a/V at rest, less that of 0. */
static PetscErrorCode AdjointAlong(Pass *pass, const Face *at, PetscInt first, const MpmKernelPoint *point,
                                   MpmKernelDirection direction, Flux *adjoint)
{
  const PetscInt dim                   = pass->map->sum->space->dim;
  PetscReal      input[MPM_MAX_INPUTS] = {0.}, rows[MPM_MAX_INPUTS * MPM_PACK] = {0.};
  Flux           still;

  PetscFunctionBeginUser;
  direction.input = rows;
  PetscCall(FindFlux(pass, at->face->point, point, input, &direction, &still));
  for (PetscInt b = 0; b < dim; b++) {
    input[first + b] = at->face->per_area[b];
    for (PetscInt j = 0; j < pass->directions->count; j++) rows[(first + b) * MPM_PACK + j] = at->per_area[j][b];
  }
  PetscCall(FindFlux(pass, at->face->point, point, input, &direction, adjoint));
  for (PetscInt k = 0; k < MPM_MAX_INPUTS; k++) adjoint->flux[k] -= still.flux[k];
  for (PetscInt k = 0; k < MPM_MAX_INPUTS * MPM_PACK; k++) adjoint->dflux[k] -= still.dflux[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pressure beyond the prescribed one, and what it changes by. */
static PetscReal Excess(const Pass *pass, const Face *at, const PetscReal weight[], const PetscReal values[])
{
  const PetscReal *p   = &values[pass->map->surfaces->component * at->n];
  PetscReal        sum = 0.;

  for (PetscInt i = 0; i < at->n; i++) sum += weight[i] * p[i];
  return sum;
}

/* c . grad phi_i, by one of the arguments of the point's basis functions, or by themselves. */
static PetscReal Slope(const MpmBasis *basis, PetscInt dim, const PetscReal c[], PetscInt stride, PetscInt i)
{
  PetscReal sum = 0.;

  for (PetscInt b = 0; b < dim; b++) sum += c[b * stride] * MpmBasisAt(basis, 1 + b, i);
  return sum;
}

static PetscErrorCode FlowAlong(Pass *pass, const Face *at, const MpmKernelPoint *point)
{
  const MpmStepMap        *map   = pass->map;
  const MpmSurfaceFaces   *faces = map->surfaces;
  MpmAlongWork            *work  = &pass->work;
  const PetscInt           dim = map->sum->space->dim, n = at->n, size = n * map->sum->block;
  const PetscInt           first     = MpmInputOf(map->sum->layout, faces->component, 1);
  const MpmKernelDirection direction = MpmAlongDirection(map, pass->directions, at->face->point, work);
  PetscReal                outflow, excess, through = 0., factor;
  Flux                     Q, c;

  PetscFunctionBeginUser;
  PetscCall(FindFlux(pass, at->face->point, point, work->point.input, &direction, &Q));
  PetscCall(AdjointAlong(pass, at, first, point, direction, &c));
  for (PetscInt b = 0; b < dim; b++) through += c.flux[first + b] * at->face->per_area[b];
  factor  = through != 0. ? at->face->penalty / through : 0.;
  excess  = Excess(pass, at, at->weight, work->point.u) - faces->pressure[at->face->surface];
  outflow = at->face->penalty * excess;
  for (PetscInt b = 0; b < dim; b++) outflow += Q.flux[first + b] * at->face->per_area[b];
  for (PetscInt j = 0; j < pass->directions->count; j++) {
    PetscReal *force = &work->force[j * size + faces->component * n], *dw = &at->dweight[j * n];
    PetscReal  dexcess = Excess(pass, at, dw, work->point.u), change = 0.;

    if (pass->directions->of[j].du) dexcess += Excess(pass, at, at->weight, &work->du[j * size]);
    for (PetscInt b = 0; b < dim; b++) {
      const PetscInt row = (first + b) * MPM_PACK + j;

      change += Q.dflux[row] * at->face->per_area[b] + Q.flux[first + b] * at->per_area[j][b] +
                factor * excess * (c.dflux[row] * at->face->per_area[b] + c.flux[first + b] * at->per_area[j][b]);
    }
    change += at->face->penalty * dexcess;
    for (PetscInt i = 0; i < n; i++) {
      force[i] -= dw[i] * outflow + at->weight[i] * change +
                  dexcess * Slope(&work->point.basis, dim, &c.flux[first], 1, i) +
                  excess * Slope(&work->point.basis, dim, &c.dflux[first * MPM_PACK + j], MPM_PACK, i);
      for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++)
        if (work->moves[k])
          force[i] -= excess * work->argument[k * MPM_PACK + j] * Slope(&work->part[k], dim, &c.flux[first], 1, i);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all faces ---- */

/* A face's part of dr, in the forces of its group's nodes. */
static PetscErrorCode FaceAlong(Pass *pass, PetscInt f)
{
  const MpmSurfaceFaces *faces = pass->map->surfaces;
  const MpmSurfaceFace  *face  = &faces->list.at[f];
  const MpmGroup        *group = &pass->map->sum->space->groups[face->group];
  Face at = {face, group, group->node_count, {{0.}}, {{0.}}, &faces->list.weight[face->weight], pass->dweight};
  MpmKernelPoint point;

  PetscFunctionBeginUser;
  MpmAlongGather(pass->map, pass->directions, group, &pass->work);
  PetscCall(MpmAlongEnter(pass->map, pass->directions, group, face->point, &pass->work, &point));
  PetscCall(GeometryAlong(pass, &at));
  LoadAlong(pass, &at);
  if (faces->surfaces->at[face->surface].held && !faces->still) PetscCall(FlowAlong(pass, &at, &point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfacesAlong(const MpmStepMap *map, const MpmStepDirections *directions)
{
  Pass pass;

  PetscFunctionBeginUser;
  if (!map->surfaces || !directions->residual || !map->surfaces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PassCreate(map, directions, &pass));
  for (PetscInt f = 0; f < map->surfaces->list.count; f++) {
    PetscCall(FaceAlong(&pass, f));
    MpmAlongScatter(map, directions, &map->sum->space->groups[map->surfaces->list.at[f].group], &pass.work);
  }
  PetscCall(PassDestroy(&pass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- transposed ---- */

/* Unit directions of one face at a time. */
typedef struct {
  Pass              pass;
  MpmStepDirection  of[MPM_PACK];
  MpmStepDirections directions;
  MpmPointVector    start;
  MpmPointVector    unit[MPM_PACK];
  MpmStageNumbers   stage;
  PetscReal        *du, *lam;
  PetscReal        *number[MPM_PACK]; /* which is 1; or NULL */
  PetscReal        *bar[MPM_PACK];
} Probe;

static PetscErrorCode ProbeCreate(const MpmStepMap *map, Probe *probe)
{
  const PetscInt local = map->sum->space->local * map->sum->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(probe, sizeof(*probe)));
  probe->directions.of = probe->of;
  PetscCall(PassCreate(map, &probe->directions, &probe->pass));
  PetscCall(MpmStageNumbersCreate(map, &probe->stage));
  PetscCall(PetscCalloc2((MPM_PACK * local + 1), &probe->du,
                         (PetscPowInt(map->sum->space->width, map->sum->space->dim) * map->sum->block), &probe->lam));
  for (PetscInt j = 0; j < MPM_PACK; j++) PetscCall(MpmStepVectorCreate(map, &probe->unit[j]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ProbeDestroy(Probe *probe)
{
  PetscFunctionBeginUser;
  for (PetscInt j = 0; j < MPM_PACK; j++) PetscCall(MpmPointVectorDestroy(&probe->unit[j]));
  PetscCall(PetscFree2(probe->du, probe->lam));
  PetscCall(MpmStageNumbersDestroy(&probe->stage));
  PetscCall(PassDestroy(&probe->pass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The directions that are there, at a face: bars += - lam . dr . */
static PetscErrorCode ProbeRun(PetscInt f, Probe *probe)
{
  const MpmStepMap *map  = probe->pass.map;
  const PetscInt    size = map->sum->space->groups[map->surfaces->list.at[f].group].node_count * map->sum->block;

  PetscFunctionBeginUser;
  if (!probe->directions.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FaceAlong(&probe->pass, f));
  for (PetscInt j = 0; j < probe->directions.count; j++) {
    for (PetscInt i = 0; i < size; i++) *probe->bar[j] -= probe->lam[i] * probe->pass.work.force[j * size + i];
    if (probe->number[j]) *probe->number[j] = 0.;
  }
  probe->directions.count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One direction more. */
static PetscErrorCode ProbeAdd(PetscInt f, PetscReal *number, PetscReal *bar, PetscInt parameter, PetscReal *du,
                               Probe *probe)
{
  const PetscInt j = probe->directions.count++;

  PetscFunctionBeginUser;
  probe->of[j]     = (MpmStepDirection){&probe->unit[j], parameter, du, NULL, &probe->stage};
  probe->number[j] = number;
  probe->bar[j]    = bar;
  if (number) *number = 1.;
  if (probe->directions.count == MPM_PACK) PetscCall(ProbeRun(f, probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The bars at a face's nodes; false where all are 0. */
static PetscBool TakeBars(const PetscReal lam[], PetscInt f, Probe *probe)
{
  const MpmSum   *sum   = probe->pass.map->sum;
  const MpmGroup *group = &sum->space->groups[probe->pass.map->surfaces->list.at[f].group];

  MpmSumGather(KnownGeneral(sum->layout, group), sum, group, lam, probe->lam);
  for (PetscInt i = 0; i < group->node_count * sum->block; i++)
    if (probe->lam[i] != 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmSurfacesPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[])
{
  Probe probe;

  PetscFunctionBeginUser;
  if (!map->surfaces || !map->surfaces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ProbeCreate(map, &probe));
  for (PetscInt f = 0; f < map->surfaces->list.count; f++) {
    const MpmGroup *group = &map->sum->space->groups[map->surfaces->list.at[f].group];

    if (!TakeBars(lam, f, &probe)) continue;
    for (PetscInt i = 0; i < group->node_count * map->sum->block; i++) {
      const PetscInt at =
        map->sum->space->group_nodes[group->node_offset + i / map->sum->block] * map->sum->block + i % map->sum->block;
      PetscReal *du = &probe.du[probe.directions.count * map->sum->space->local * map->sum->block];

      PetscCall(ProbeAdd(f, &du[at], &u[at], -1, du, &probe));
    }
    PetscCall(ProbeRun(f, &probe));
  }
  PetscCall(ProbeDestroy(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfacesPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                    PetscReal gradient[])
{
  Probe probe;

  PetscFunctionBeginUser;
  if (!map->surfaces || !map->surfaces->list.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ProbeCreate(map, &probe));
  for (PetscInt f = 0; f < map->surfaces->list.count; f++) {
    const PetscInt p = map->surfaces->list.at[f].point;

    if (!TakeBars(lam, f, &probe)) continue;
    for (PetscInt k = 0; k < MPM_VECTOR_FIELDS; k++) {
      if (k == MPM_VECTOR_GRADIENT || k == MPM_VECTOR_ORIGIN || k == MPM_VECTOR_MASS) continue;
      for (PetscInt c = 0; c < start->size[k]; c++) {
        PetscReal *number = &probe.unit[probe.directions.count].at[k][p * start->size[k] + c];

        PetscCall(ProbeAdd(f, number, &start->at[k][p * start->size[k] + c], -1, NULL, &probe));
      }
    }
    for (PetscInt k = 0; k < map->parameters->count; k++)
      if (MpmPointHasParameter(map, &map->parameters->at[k], p) ||
          MpmPhysicsHasParameter(&map->parameters->at[k], map->sum->points->material[p]))
        PetscCall(ProbeAdd(f, NULL, &gradient[k], k, NULL, &probe));
    PetscCall(ProbeRun(f, &probe));
  }
  PetscCall(ProbeDestroy(&probe));
  PetscFunctionReturn(PETSC_SUCCESS);
}
