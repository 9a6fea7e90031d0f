// The complete state of ODE's bodies and hinges, to the last bit.
#pragma once

#include "bodies.hh"

namespace nrp
{
/// Add the seed of ODE's generator, position, orientation (w, x, y, z) and velocities of each body, and the angle
/// that each hinge keeps.
void AddSaved(const Bodies &bodies, Writer &answer);

/// Restore such a state.
void Restore(const Bodies &bodies, Reader &saved);
}  // namespace nrp
