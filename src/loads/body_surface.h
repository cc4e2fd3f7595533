#pragma once
/*
  Surfaces of bodies, with their loads: options (body_surface.c), the faces of a step (surface_faces.c) and the
  term (surface_load.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/tables.h"
#include "loads/edge_pieces.h"

/*
  Faces of a body's points that bound the material, on one side of the lattice or on all; or those of any body that
  touch a drained boundary.
*/
typedef struct {
  char                   *name;
  PetscInt                body, faces;     /* body: or -1; faces: bits of those that belong to it (outer_faces.h) */
  PetscInt                boundary;        /* index of a drained boundary, or -1 */
  const struct MpmBodies *cut;             /* all bodies, where this one's edge cuts boxes (edge: cut); or NULL */
  MpmRegion               region;          /* of the faces' places in the initial state; NULL: everywhere */
  PetscReal traction[MPM_MAX_DIM], normal; /* Pa on the current faces: a vector; the stress along the outward normal */
  PetscBool loaded;
  MpmRamp   ramp;                  /* of both, and of the pressure where it is given */
  PetscBool held, drained, ramped; /* water passes at a pressure; which has the ramp */
  PetscReal pressure;              /* of the water, Pa */
} MpmBodySurface;

/* Surfaces, with the names of their blocks, and behind these drained boundaries with theirs. */
typedef struct MpmBodySurfaces {
  PetscInt        count, named; /* named: surfaces */
  char          **names;
  MpmBodySurface *at;
} MpmBodySurfaces;

/* A face that belongs to a surface, as the step starts. */
typedef struct {
  PetscInt  surface, point, group;
  PetscInt  weight;                /* where its weights at the group's nodes stand */
  PetscReal area[MPM_MAX_DIM];     /* outward, m^(dim-1) */
  PetscReal per_area[MPM_MAX_DIM]; /* area over the point's volume, 1/m */
  PetscReal adjoint[MPM_MAX_DIM];  /* of drained ones: weights of grad phi in the adjoint term (surface_flow.c) */
  PetscReal penalty;
  PetscReal place[MPM_MAX_DIM]; /* of its middle */
  PetscInt  inner;              /* where its point's inner areas at the group's nodes stand (surface_cut.c); -1: none */
  PetscReal water;              /* pressure of the open water at the step's end, Pa: on drained ones */
  PetscReal rest;               /* pressure of water at rest in the ground, Pa: behind drained ones */
} MpmSurfaceFace;

/* Faces by groups, with their weights; `weights`: as many have room, `used`: as many there are. */
typedef struct {
  PetscInt        count, capacity, weights, used;
  MpmSurfaceFace *at;
  PetscReal      *weight; /* and inner areas, dim a node */
} MpmSurfaceFaceList;

/* Those of this rank's points. */
typedef struct MpmSurfaceFaces {
  const MpmBodySurfaces *surfaces;
  MpmLoadActing         *acting;            /* by surface */
  const MpmContacts     *contacts;          /* whose boundaries some are */
  const MpmConditions   *bcs;               /* on planes of symmetry */
  const MpmActing       *bcs_acting;        /* by condition */
  PetscReal             *factor, *pressure; /* by surface, at the step's end */
  PetscReal             *mean;              /* factor by surface with which loads do their work in the step */
  PetscReal             *outflow;           /* by surface, of the step or its second sub-step, m3 */
  PetscReal             *first;             /* by surface, weighted contribution of the first sub-step, m3 */
  PetscBool              any_held;
  const MpmWaterTable   *table;     /* of the open water */
  PetscBool              still;     /* no flow: the water's pressure is not solved for */
  PetscReal              open;      /* active fraction of open water in a geostatic stage; otherwise 1 */
  const MpmKernelSet    *kernel;    /* of the physics without means over cells */
  PetscInt               component; /* of a node's unknowns: the pressure; -1: there is none */
  MpmSurfaceFaceList     list;
  struct {
    MpmEdgePieces *pieces;  /* by surface, of bodies whose edge is cut */
    PetscBool     *present; /* by body, whether it has points; of scenes with those */
  } drawn;
} MpmSurfaceFaces;

/* `layout` is that of the scene's physics; tolerances of regions by axis, m. */
PetscErrorCode MpmBodySurfaceCreate(const MpmOptions *options, const char *name, const MpmLayout *layout,
                                    const PetscReal tolerance[], const MpmBodies *bodies, MpmBodySurface *surface);
/* Adds drained boundaries to the list of surfaces, of which count and names are there. */
PetscErrorCode MpmBodySurfacesAddDrained(const MpmBoundaries *boundaries, MpmBodySurfaces *surfaces);
/* True where open water stands below its level on one of them. */
PetscBool      MpmSurfacesOpen(const MpmBodySurfaces *surfaces);
PetscErrorCode MpmBodySurfacesDestroy(MpmBodySurfaces *surfaces);
/* Surfaces and their active loads are borrowed; the latter stand one behind the other. */
PetscErrorCode MpmSurfaceFacesCreate(const MpmBodySurfaces *surfaces, MpmLoadActing *acting, MpmSurfaceFaces *faces);
PetscErrorCode MpmSurfaceFacesDestroy(MpmSurfaceFaces *faces);
/* Finds the step's faces and their weights (a term's `boxes`). Collective. */
PetscErrorCode MpmSurfaceFacesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
/* Marks the local nodes at which water passes faces, those of ghosts at their owners; others become 0. */
PetscErrorCode MpmSurfaceFlowMark(const MpmSurfaceFaces *faces, const MpmSpace *space, PetscReal mark[]);
/*
  The conditions that constrain faces of a surface on all sides along their normals, 1 by condition. Such faces lie on
  planes of symmetry and are left out. Collective.
*/
PetscErrorCode MpmSurfaceFacesFindHeld(const MpmSurfaceFaces *faces, const MpmGrid *grid, MpmParticles *particles,
                                       PetscInt surface, PetscInt held[]);
/* Whether it is a body's on all sides. */
PetscBool MpmBodySurfaceIsAll(const MpmBodySurface *surface, PetscInt dim);
/* Adds the flow in the step that u ends; before the points take it over. Collective. */
PetscErrorCode MpmSurfaceFlowCommit(MpmSurfaceFaces *faces, const MpmSum *sum, const PetscReal u[]);
/* Refuses surfaces that act, and whose bodies are there, without a face. Collective. */
PetscErrorCode MpmBodySurfacesCheck(const MpmBodySurfaces *surfaces, const MpmLoadActing *acting, const MpmGrid *grid,
                                    MpmParticles *particles);
extern const MpmTerm MpmTermSurfaces;    /* loads on them (surface_load.c); ctx: MpmSurfaceFaces */
extern const MpmTerm MpmTermSurfaceFlow; /* water that passes (surface_flow.c); likewise */
