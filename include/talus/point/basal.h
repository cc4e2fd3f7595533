#pragma once
/*
  Laws of the bed: resistance to a layer that flows over it, of depth-averaged flow (physics depth_averaged).

  A law is one file of basal/ with MPM_BASAL(name, ...): a table of parameters as laws have it, behind the two that all
  share, and a function. The engine takes the resistance implicitly at the nodes: it must not fall with the speed.
*/
#include "tables.h"

/* A layer over its bed: what its resistance depends on. */
typedef struct MpmBasalPoint {
  double depth;    /* normal to the bed with -mpm_slope normal, otherwise vertical, m, > 0 */
  double pressure; /* normal to the bed, Pa, >= 0 */
  double speed;    /* along the bed, the mean over the depth, m/s, >= 0 */
} MpmBasalPoint;

/* Shear stress at the bed against the motion, Pa. */
typedef double (*MpmBasalResistance)(const double *parameter, const MpmBasalPoint *point);

/* Trait of a physics beside MpmPhysicsTrait: points are columns on a bed, volumes those of the columns; laws are those
   of beds. */
#define MPM_PHYSICS_COLUMNS 256u

/*
  resistance  shear stress at the bed against the motion, Pa; at speed 0 the largest that holds the layer
  check       0 where parameters contradict each other, with the contradiction in `fault`; NULL: none can
*/
typedef struct MpmBasalLaw {
  const char         *name, *summary;
  const MpmParameter *parameters;
  size_t              parameter_count;
  int (*check)(const double *parameter, const MpmLawTable *table, MpmLawFault *fault);
  MpmBasalResistance resistance;
} MpmBasalLaw;

/* The first rows of all parameter tables, and their places. */
enum { MPM_BASAL_DENSITY, MPM_BASAL_GRAVITY, MPM_BASAL_INTERNAL, MPM_BASAL_OWN };
#define MPM_BASAL_GRAVITY_EARTH 9.81
#define MPM_BASAL_SHARED \
  {MPM_NUMBER, "density", "kg/m3", 0., 1, 0., HUGE_VAL, 1, "of the flowing mixture", NULL, 1300., NULL}, \
    {MPM_NUMBER, "gravity", "m/s2", MPM_BASAL_GRAVITY_EARTH, 0, 0., HUGE_VAL, 1, "downwards", NULL, 9.81, NULL}, \
  { \
    MPM_NUMBER, "internal_friction", "degrees", HUGE_VAL, 0, 0., 89., 0, \
      "for active and passive earth pressure along the bed; without: that of a fluid", NULL, 35., NULL \
  }

/* MPM_BASAL(voellmy, parameters, Check or NULL, Resistance, "one line for -help") */
#define MPM_BASAL(name_, parameters_, check_, resistance_, summary_) \
  extern const MpmBasalLaw MpmBasal_##name_; \
  const MpmBasalLaw MpmBasal_##name_ = {#name_, summary_,   parameters_, sizeof(parameters_) / sizeof(*parameters_), \
                                        check_, resistance_};
