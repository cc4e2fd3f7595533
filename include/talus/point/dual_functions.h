/*
  Functions of numbers with derivatives that need only NUMBER_(Chain) and NUMBER_(Chain2), the chain rule. Included by
  dual.h once for each type NUMBER; no include guard.
*/
MPM_FN NUMBER NUMBER_(Div)(NUMBER a, NUMBER b)
{
  const double inverse = 1. / NUMBER_(Value)(b), f = NUMBER_(Value)(a) * inverse; /* one division: they are slow */

  return NUMBER_(Chain2)(a, b, f, inverse, -f * inverse);
}

/* a + beta */
MPM_FN NUMBER NUMBER_(Shift)(NUMBER a, Real beta)
{
#if defined(MPM_SENSITIVITY)
  return NUMBER_(Add)(a, NUMBER_(Constant)(beta));
#else
  return NUMBER_(Chain)(a, NUMBER_(Value)(a) + beta, 1.);
#endif
}

MPM_FN NUMBER NUMBER_(Neg)(NUMBER a)
{
  return NUMBER_(Chain)(a, -NUMBER_(Value)(a), -1.);
}

/* Has no derivative at 0: test the value first. */
MPM_FN NUMBER NUMBER_(Sqrt)(NUMBER a)
{
  const double f = sqrt(NUMBER_(Value)(a));

  return NUMBER_(Chain)(a, f, 0.5 / f);
}

/* The logarithm of one, which plane strain asks for at every point, costs nothing. */
MPM_FN NUMBER NUMBER_(Log)(NUMBER a)
{
  if (NUMBER_(Value)(a) == 1.) return NUMBER_(Chain)(a, 0., 1.);
  return NUMBER_(Chain)(a, log(NUMBER_(Value)(a)), 1. / NUMBER_(Value)(a));
}

/* ln(1 + a) without cancellation at small a */
MPM_FN NUMBER NUMBER_(Log1p)(NUMBER a)
{
  return NUMBER_(Chain)(a, log1p(NUMBER_(Value)(a)), 1. / (1. + NUMBER_(Value)(a)));
}

/* exp(a) - 1 without cancellation at small a */
MPM_FN NUMBER NUMBER_(Expm1)(NUMBER a)
{
  const double f = expm1(NUMBER_(Value)(a));

  return NUMBER_(Chain)(a, f, f + 1.);
}

MPM_FN NUMBER NUMBER_(Exp)(NUMBER a)
{
  const double f = exp(NUMBER_(Value)(a));

  return NUMBER_(Chain)(a, f, f);
}

/* a^p for an exponent that does not depend on the increment, and a > 0 */
MPM_FN NUMBER NUMBER_(Pow)(NUMBER a, Real exponent)
{
#if defined(MPM_SENSITIVITY)
  const double x = NUMBER_(Value)(a), p = RealValue(exponent), f = pow(x, p);

  return NUMBER_(Chain2)(a, NUMBER_(Constant)(exponent), f, p * f / x, f * log(x));
#else
  const double f = pow(NUMBER_(Value)(a), exponent);

  return NUMBER_(Chain)(a, f, exponent * f / NUMBER_(Value)(a));
#endif
}

MPM_FN NUMBER NUMBER_(Sin)(NUMBER a)
{
  return NUMBER_(Chain)(a, sin(NUMBER_(Value)(a)), cos(NUMBER_(Value)(a)));
}

MPM_FN NUMBER NUMBER_(Cos)(NUMBER a)
{
  return NUMBER_(Chain)(a, cos(NUMBER_(Value)(a)), -sin(NUMBER_(Value)(a)));
}
