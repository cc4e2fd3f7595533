#pragma once
#include <petscsnes.h>

/* Why Newton's method has given up, for people; static text. */
const char *MpmNewtonReason(SNESConvergedReason reason);
