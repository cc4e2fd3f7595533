#pragma once
/*
  Names of the engine's types, for headers that only hand pointers to them around; what they are stands in the header of
  their own folder, which a file includes when it looks inside. And choices of a scene that are handed around alike.
*/

/* base, options, geometry */
typedef struct MpmOutcome    MpmOutcome;
typedef struct MpmRows       MpmRows;
typedef struct MpmColumns    MpmColumns;
typedef struct MpmDatabase   MpmDatabase;
typedef struct MpmOptions    MpmOptions;
typedef struct _p_MpmRecord *MpmRecord;
typedef struct _p_MpmRegion *MpmRegion;
typedef struct _p_MpmRamp   *MpmRamp;

/* point, grid, particles */
typedef struct MpmLayout      MpmLayout;
typedef struct MpmMaterial    MpmMaterial;
typedef struct MpmMaterials   MpmMaterials;
typedef struct MpmVariations  MpmVariations;
typedef struct MpmPlace       MpmPlace;
typedef struct MpmGround      MpmGround;
typedef struct MpmGrounds     MpmGrounds;
typedef struct MpmGrid        MpmGrid;
typedef struct MpmSplit       MpmSplit;
typedef struct MpmBodies      MpmBodies;
typedef struct _p_MpmBody    *MpmBody;
typedef struct _p_MpmRamp    *MpmRamp;
typedef struct MpmParked      MpmParked;
typedef struct MpmBed         MpmBed;
typedef struct MpmBasalLaw    MpmBasalLaw;
typedef struct MpmParticles   MpmParticles;
typedef struct MpmPoints      MpmPoints;
typedef struct MpmPointVector MpmPointVector;
/* The diagonal of U = sqrt(F^T F); non-zero where F has none. */
typedef int (*MpmStretch)(const double *F, double *diagonal);

/* space, bc */
typedef struct MpmFace        MpmFace;
typedef struct MpmGroup       MpmGroup;
typedef struct MpmRules       MpmRules;
typedef struct MpmSpace       MpmSpace;
typedef struct MpmSum         MpmSum;
typedef struct MpmSumStep     MpmSumStep;
typedef struct MpmTransfer    MpmTransfer;
typedef struct MpmTrial       MpmTrial;
typedef struct MpmWall        MpmWall;
typedef struct MpmWaterAtRest MpmWaterAtRest;
typedef struct MpmConditions  MpmConditions;
typedef struct MpmActing      MpmActing;
typedef struct MpmBodyMotions MpmBodyMotions;
typedef struct MpmConstraints MpmConstraints;

/* terms, time */
typedef struct MpmAddedTerms     MpmAddedTerms;
typedef struct MpmBodySurfaces   MpmBodySurfaces;
typedef struct MpmBoundaries     MpmBoundaries;
typedef struct MpmContacts       MpmContacts;
typedef struct MpmDiscretization MpmDiscretization;
typedef struct MpmDamping        MpmDamping;
typedef struct MpmBedFlow        MpmBedFlow;
typedef struct MpmInertia        MpmInertia;
typedef struct MpmLoads          MpmLoads;
typedef struct MpmLoadActing     MpmLoadActing;
typedef struct MpmPairs          MpmPairs;
typedef struct MpmPairContacts   MpmPairContacts;
typedef struct MpmPattern        MpmPattern;
typedef struct MpmFreedom        MpmFreedom;
typedef struct MpmPlacement      MpmPlacement;
typedef struct MpmRigidBody      MpmRigidBody;
typedef struct MpmSections       MpmSections;
typedef struct MpmSurfaceFaces   MpmSurfaceFaces;
typedef struct MpmTerm           MpmTerm;
typedef struct MpmTermStep       MpmTermStep;
typedef struct MpmTerms          MpmTerms;
typedef struct MpmStage          MpmStage;
typedef struct MpmWaterTable     MpmWaterTable;
typedef struct MpmIntegrator     MpmIntegrator;
typedef struct MpmSdirk          MpmSdirk;
typedef struct MpmDynamics       MpmDynamics;

/*E
  MpmShapeType - the shape functions, by the names that the option -mpm_shape takes
E*/
typedef enum {
  MPM_SHAPE_LINEAR,        /* linear basis functions at the point */
  MPM_SHAPE_GIMP,          /* linear, averaged over the point's domain (contiguous-particle GIMP) */
  MPM_SHAPE_BSPLINE2,      /* quadratic B-spline at the point */
  MPM_SHAPE_BSPLINE3,      /* cubic B-spline at the point */
  MPM_SHAPE_GIMP_BSPLINE2, /* quadratic B-spline averaged over the point's domain */
  MPM_SHAPE_COUNT,         /* of shapes whose nodes are the grid's vertices */
  /* Lagrange elements of order 2 to 4, of nodes within cells (-mpm_order); those of order 1 are the linear shapes */
  MPM_SHAPE_ELEMENT2 = MPM_SHAPE_COUNT,
  MPM_SHAPE_ELEMENT3,
  MPM_SHAPE_ELEMENT4,
  MPM_SHAPE_GIMP_ELEMENT2, /* averaged over the point's domain */
  MPM_SHAPE_GIMP_ELEMENT3,
  MPM_SHAPE_GIMP_ELEMENT4
} MpmShapeType;

/*E
  MpmEdgeType - how B-splines end at an edge, by the names that the option -mpm_shape_edge takes; linear basis
  functions (linear, gimp) have nothing beyond an edge
E*/
typedef enum {
  MPM_EDGE_LINEAR, /* coefficients beyond extend the others linearly: no second derivative there */
  MPM_EDGE_OPEN    /* not-a-knot: polynomials of the spline's degree up to the edge */
} MpmEdgeType;
