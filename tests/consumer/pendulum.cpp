#include "pendulum.hpp"

SALVO_DEFINE_MODEL(pendulum, Pendulum)
