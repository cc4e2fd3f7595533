#pragma once
/*
  How a file in materials/ or src/kernels/ makes itself known, once per instance. Included by mpmkernel.h.
*/

/*
  MPM_LAW(name, traits, summary, parameters, states, check, stiffness, kernel) - constructor of a constitutive law

  `parameters` and `states` are the file's static tables; a law without history passes MPM_NO_STATE for `states`.
*/
#define MPM_LAW(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_) \
  void MPM_INSTANCE(MpmMaterialCreate_##name_)(MpmLawInfo * info); \
  void MPM_INSTANCE(MpmMaterialCreate_##name_)(MpmLawInfo * info) \
  { \
    const MPM_INSTANCE(MpmLaw) law = kernel_; \
    info->name                     = #name_; \
    info->summary                  = summary_; \
    info->parameters               = parameters_; \
    info->parameter_count          = sizeof(parameters_) / sizeof((parameters_)[0]); \
    info->states                   = states_; \
    info->state_count              = sizeof(states_) / sizeof((states_)[0]); \
    if (info->state_count == 1 && !info->states[0].name) info->state_count = 0; \
    info->traits    = traits_; \
    info->check     = check_; \
    info->stiffness = stiffness_; \
    info->law       = (MpmFunction)law; \
  }

/* The state table of a law without history: static const MpmStateVariable states[] = MPM_NO_STATE; */
#define MPM_NO_STATE \
  { \
    { \
      NULL, MPM_STATE_SCALAR, 0., NULL \
    } \
  }

/*
  MPM_KERNEL(name, inputs, kernel) - a physics' kernel of this instance, in plain doubles: it fills its slot of the
  kernel set
*/
#define MPM_KERNEL_CREATE(name_, ...) \
  void MPM_INSTANCE(MpmKernelCreate_##name_)(MpmKernelSet * set); \
  void MPM_INSTANCE(MpmKernelCreate_##name_)(MpmKernelSet * set) \
  { \
    __VA_ARGS__ \
  }
#if MPM_DIRECTIONS == 0
#define MPM_KERNEL_FORM                     MPM_FORM_RESIDUAL
#define MPM_KERNEL(name_, inputs_, kernel_) MPM_KERNEL_CREATE(name_, set->inputs = inputs_; set->residual = kernel_;)
#elif MPM_DIRECTIONS == 1
#define MPM_KERNEL_FORM MPM_FORM_DIRECTION
#define MPM_KERNEL(name_, inputs_, kernel_) \
  static int Direction_##name_(const MpmKernelPoint *point, const double *input, const double *dinput, double *flux, \
                               double *dflux) \
  { \
    Scalar in[inputs_], out[inputs_]; \
    for (int k = 0; k < inputs_; k++) in[k] = ScalarShift(ScalarScale(dinput[k], ScalarSeed(0., 0)), input[k]); \
    const int failed = kernel_(point, in, out); \
    for (int k = 0; k < inputs_; k++) { \
      flux[k]  = ScalarValue(out[k]); \
      dflux[k] = ScalarDirection(out[k], 0); \
    } \
    return failed; \
  } \
  MPM_KERNEL_CREATE(name_, set->direction = Direction_##name_;)
#else
#define MPM_KERNEL_FORM MPM_FORM_TANGENT
#define MPM_KERNEL(name_, inputs_, kernel_) \
  static int Tangent_##name_(const MpmKernelPoint *point, const double *input, double *flux, double *tangent) \
  { \
    Scalar in[inputs_], out[inputs_]; \
    for (int k = 0; k < inputs_; k++) in[k] = ScalarSeed(input[k], k); \
    const int failed = kernel_(point, in, out); \
    for (int k = 0; k < inputs_; k++) { \
      flux[k] = ScalarValue(out[k]); \
      for (int l = 0; l < inputs_; l++) tangent[k * (inputs_) + l] = ScalarDirection(out[k], l); \
    } \
    return failed; \
  } \
  MPM_KERNEL_CREATE(name_, set->tangent = Tangent_##name_;)
#endif

/*
  MPM_KERNEL_MEAN(name, inputs, kernel, mean, tangent) - the same for a kernel whose last input is a mean over the cell;
  it has one direction fewer than inputs, and brings its own tangent
*/
#if MPM_DIRECTIONS == 0
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) \
  MPM_KERNEL_CREATE(name_, set->inputs = inputs_; set->residual = kernel_; set->mean = mean_;)
#elif MPM_DIRECTIONS == 1
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) MPM_KERNEL(name_, inputs_, kernel_)
#else
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) \
  MPM_KERNEL_CREATE(name_, set->tangent = tangent_; set->mean_tangent = mean_;)
#endif
