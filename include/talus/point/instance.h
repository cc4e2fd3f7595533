#pragma once
/*
  How a file in materials/ or physics/ makes itself known, once per instance. Included by law.h.
*/

/* Linkage of the functions that the engine calls; instances with MPM_SENSITIVITY are compiled as C++ where there is a
   compiler for it. */
#if defined(__cplusplus)
#define MPM_LINKAGE extern "C"
#else
#define MPM_LINKAGE
#endif

/* Rows of a static table */
#define MPM_ROWS(table_) (sizeof(table_) / sizeof((table_)[0]))

/*
  Entry of the engine: the kernel itself or, in the instance that differentiates by all arguments of a law, a function
  of plain numbers around it.
*/
#if defined(MPM_SENSITIVITY)
#include "sensitivity.h"
#define MPM_LAW_FUNCTION(name_, kernel_) Sensitivity_##name_
#define MPM_LAW_ENTRY(name_, parameters_, states_, kernel_) \
  static int Sensitivity_##name_(const MpmLawInput *input, const MpmLawInput *direction, const MpmLawOutput *value, \
                                 const MpmLawOutput *derivative) \
  { \
    const size_t  size = LawStateSize(states_, MPM_ROWS(states_)); \
    Real          parameter[MPM_ROWS(parameters_)], F_n[MPM_TENSOR]; \
    Real          state_n[MPM_ROWS(states_) * MPM_SYM], state[MPM_ROWS(states_) * MPM_SYM]; \
    const LawRoom room = {parameter, state_n, value->state ? state : NULL, F_n, MPM_ROWS(parameters_), size}; \
    Tensor        dF; \
    Sym           tau; \
\
    for (int first = 0; !first || first < direction->count; first += REAL_DIRECTIONS) { \
      const RealColumns columns = LawColumns(first, direction->count, direction->stride); \
      const MpmLawPoint point   = LawPointCreate(input, direction, columns, &room, &dF); \
\
      if (kernel_(&point, &dF, &tau)) return 1; \
      LawSplit(MPM_SYM, tau.a, columns, value->tau, derivative->tau); \
      if (value->state) LawSplit(size, state, columns, value->state, derivative->state); \
    } \
    return 0; \
  }
typedef MpmSensitivity MpmLawEntry;
/*
  MPM_LAW_DILATANCY(name, parameters, states, function) - before MPM_LAW_DEFINE(): a law's MpmDilatancy with Reals in
  place of doubles; MPM_DILATANCY(name, function) - its members of MpmLawInfo
*/
#define MPM_LAW_DILATANCY(name_, parameters_, states_, function_) \
  static void Dilatancy_##name_(const MpmLawInput *input, const MpmLawInput *direction, double value[4], \
                                double *derivative) \
  { \
    for (int first = 0; !first || first < direction->count; first += REAL_DIRECTIONS) { \
      const RealColumns columns = LawColumns(first, direction->count, direction->stride); \
      Real parameter[MPM_ROWS(parameters_)], state[MPM_ROWS(states_) * MPM_SYM], answer[4] = {0., 0., 0., 0.}; \
\
      LawJoin(MPM_ROWS(parameters_), input->parameter, direction->parameter, columns, parameter); \
      LawJoin(LawStateSize(states_, MPM_ROWS(states_)), input->state_n, direction->state_n, columns, state); \
      answer[0] = function_(parameter, input->table, state, &answer[1]); \
      LawSplit(4, answer, columns, value, derivative); \
    } \
  }
#define MPM_DILATANCY(name_, function_) .dilatancy_sensitivity = Dilatancy_##name_
/*
  MPM_LAW_MODULI(name, parameters, states, function) - before MPM_LAW_DEFINE(): function(parameter, state, F, moduli),
  of Reals, finds the moduli of MpmModuliSensitivity; MPM_MODULI(name) - its member of MpmLawInfo
*/
#define MPM_LAW_MODULI(name_, parameters_, states_, function_) \
  static void Moduli_##name_(const MpmLawInput *input, const MpmLawInput *direction, double value[3], \
                             double *derivative) \
  { \
    for (int first = 0; !first || first < direction->count; first += REAL_DIRECTIONS) { \
      const RealColumns columns = LawColumns(first, direction->count, direction->stride); \
      Real              parameter[MPM_ROWS(parameters_)], state[MPM_ROWS(states_) * MPM_SYM], F[MPM_TENSOR], moduli[3]; \
\
      LawJoin(MPM_ROWS(parameters_), input->parameter, direction->parameter, columns, parameter); \
      LawJoin(LawStateSize(states_, MPM_ROWS(states_)), input->state_n, direction->state_n, columns, state); \
      LawJoin(MPM_TENSOR, input->F_n, direction->F_n, columns, F); \
      function_(parameter, state, F, moduli); \
      LawSplit(3, moduli, columns, value, derivative); \
    } \
  }
#define MPM_MODULI(name_) .moduli_sensitivity = Moduli_##name_
#else
#define MPM_LAW_FUNCTION(name_, kernel_) kernel_
#define MPM_LAW_ENTRY(name_, parameters_, states_, kernel_)
#define MPM_LAW_DILATANCY(name_, parameters_, states_, function_)
#define MPM_DILATANCY(name_, function_) .dilatancy = function_
#define MPM_LAW_MODULI(name_, parameters_, states_, function_)
#define MPM_MODULI(name_) .moduli_sensitivity = NULL
typedef MPM_INSTANCE(MpmLaw) MpmLawEntry;
#endif

/*
  MPM_LAW_DEFINE(name, parameters, states, kernel, .summary = ..., .traits = ..., .stiffness = ..., ...) - constructor
  of a constitutive law: its static tables, its kernel, and further properties as members of MpmLawInfo

  A law without history passes MPM_NO_STATE for `states`. Functions that are left out are NULL; `stiffness` is a must,
  and `shear_modulus` where a pressure field is to be stabilized.
*/
#define MPM_LAW_DEFINE(name_, parameters_, states_, kernel_, ...) \
  MPM_LAW_ENTRY(name_, parameters_, states_, kernel_) \
  MPM_LINKAGE void MPM_INSTANCE(MpmMaterialCreate_##name_)(MpmLawInfo * info); \
  MPM_LINKAGE void MPM_INSTANCE(MpmMaterialCreate_##name_)(MpmLawInfo * info) \
  { \
    const MpmLawEntry law = MPM_LAW_FUNCTION(name_, kernel_); \
    *info                 = (MpmLawInfo){__VA_ARGS__}; \
    info->name            = #name_; \
    info->parameters      = parameters_; \
    info->parameter_count = MPM_ROWS(parameters_); \
    info->states          = states_; \
    info->state_count     = MPM_ROWS(states_); \
    info->law             = (MpmFunction)law; \
    if (info->state_count == 1 && !info->states[0].name) info->state_count = 0; \
  }

/*
  Definitions by position, without a shear modulus: MPM_LAW(name, traits, summary, parameters, states, check, stiffness,
  kernel), MPM_LAW_MORE(..., kernel, symmetric, history), MPM_LAW_ALL(..., kernel, symmetric, history, k0),
  MPM_LAW_DILATANT(..., k0, dilatancy) and MPM_LAW_LIMITED(..., k0, dilatancy, shear_strength); functions may be NULL.
*/
#define MPM_LAW(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_) \
  MPM_LAW_MORE(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, NULL, NULL)

#define MPM_LAW_MORE(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, \
                     history_) \
  MPM_LAW_ALL(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, history_, NULL)

#define MPM_LAW_ALL(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, history_, \
                    k0_) \
  MPM_LAW_DILATANT(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, history_, \
                   k0_, NULL)

#define MPM_LAW_DILATANT(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, \
                         history_, k0_, dilatancy_) \
  MPM_LAW_LIMITED(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, history_, \
                  k0_, dilatancy_, NULL)

#define MPM_LAW_LIMITED(name_, traits_, summary_, parameters_, states_, check_, stiffness_, kernel_, symmetric_, \
                        history_, k0_, dilatancy_, shear_strength_) \
  MPM_LAW_DEFINE(name_, parameters_, states_, kernel_, .traits = (traits_), .summary = summary_, .check = check_, \
                 .stiffness = stiffness_, .symmetric = symmetric_, .history = history_, .k0 = k0_, \
                 .dilatancy = dilatancy_, .shear_strength = shear_strength_)

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
  MPM_LINKAGE void MPM_INSTANCE(MpmKernelCreate_##name_)(MpmKernelSet * set); \
  MPM_LINKAGE void MPM_INSTANCE(MpmKernelCreate_##name_)(MpmKernelSet * set) \
  { \
    __VA_ARGS__ \
  }
#if defined(MPM_SENSITIVITY)
#define MPM_KERNEL_SENSITIVITY(name_, inputs_, kernel_) \
  static int Sensitivity_##name_(const MpmKernelPoint *values, const double *input, \
                                 const MpmKernelDirection *direction, double *flux, double *dflux, \
                                 const MpmKernelEnd *derivative) \
  { \
    KernelRoom room; \
    Scalar     in[inputs_], out[inputs_]; \
\
    for (int first = 0; !first || first < direction->count; first += REAL_DIRECTIONS) { \
      const KernelPoint point = KernelPointCreate(values, direction, first, derivative, &room); \
\
      LawJoin(inputs_, input, direction->input, point.columns, in); \
      if (kernel_(&point, in, out)) return 1; \
      LawSplit(inputs_, out, point.columns, flux, dflux); \
      KernelSplitEnd(&point, derivative); \
    } \
    return 0; \
  }
#define MPM_KERNEL(name_, inputs_, kernel_) \
  MPM_KERNEL_SENSITIVITY(name_, inputs_, kernel_) \
  MPM_KERNEL_CREATE(name_, set->sensitivity = Sensitivity_##name_;)
#elif MPM_DIRECTIONS == 0
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

/* MPM_KERNEL_TANGENT(name, inputs, kernel, tangent) - the same for a kernel that brings its own tangent, likewise */
#if MPM_DIRECTIONS < 2
#define MPM_KERNEL_TANGENT(name_, inputs_, kernel_, tangent_) MPM_KERNEL(name_, inputs_, kernel_)
#else
#define MPM_KERNEL_TANGENT(name_, inputs_, kernel_, tangent_) MPM_KERNEL_CREATE(name_, set->tangent = tangent_;)
#endif

/*
  MPM_KERNEL_MEAN(name, inputs, kernel, mean, tangent) - the same for a kernel whose last input is a mean over the cell;
  it brings its own tangent, with as many directions as it takes for that. In the instances with MPM_SENSITIVITY `mean`
  takes a KernelPoint and Scalars: int mean(point, input, Scalar *m, Scalar dm[])
*/
#if defined(MPM_SENSITIVITY)
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) \
  MPM_KERNEL_SENSITIVITY(name_, inputs_, kernel_) \
  static int MeanSensitivity_##name_(const MpmKernelPoint *values, const double *input, \
                                     const MpmKernelDirection *direction, double *m, double *dm, double *ddm) \
  { \
    KernelRoom room; \
    Scalar     in[(inputs_)-1], mean, derivative[(inputs_)-1]; \
\
    for (int first = 0; !first || first < direction->count; first += REAL_DIRECTIONS) { \
      const KernelPoint point = KernelPointCreate(values, direction, first, NULL, &room); \
\
      LawJoin((inputs_)-1, input, direction->input, point.columns, in); \
      if (mean_(&point, in, &mean, derivative)) return 1; \
      LawSplit(1, &mean, point.columns, &m[0], &m[1]); \
      LawSplit((inputs_)-1, derivative, point.columns, dm, ddm); \
    } \
    return 0; \
  } \
  MPM_KERNEL_CREATE(name_, set->sensitivity = Sensitivity_##name_; set->mean_sensitivity = MeanSensitivity_##name_;)
#elif MPM_DIRECTIONS == 0
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) \
  MPM_KERNEL_CREATE(name_, set->inputs = inputs_; set->residual = kernel_; set->mean = mean_;)
#elif MPM_DIRECTIONS == 1
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) MPM_KERNEL(name_, inputs_, kernel_)
#else
#define MPM_KERNEL_MEAN(name_, inputs_, kernel_, mean_, tangent_) \
  MPM_KERNEL_CREATE(name_, set->tangent = tangent_; set->mean_tangent = mean_;)
#endif

/*
  MPM_PHYSICS(name, .summary = ..., .fields = ..., ...) - properties of a physics besides its kernel, as members of
  MpmPhysics; once, in the first instance. MPM_ROWS() counts the rows of the file's static tables.
*/
#if MPM_DIM == 2 && MPM_DIRECTIONS == 0 && !defined(MPM_AXISYMMETRIC)
#define MPM_PHYSICS(name_, ...) \
  void MpmPhysicsDescribe_##name_(MpmPhysics *physics); \
  void MpmPhysicsDescribe_##name_(MpmPhysics *physics) \
  { \
    *physics = (MpmPhysics){.name = #name_, __VA_ARGS__}; \
  }
#endif
