// Rays of laser scanners, which meet the collision shapes as ODE has them.
#pragma once

#include "bodies.hh"

namespace nrp
{
/// Add the distance along each ray, infinite for one that meets nothing. The shapes of some links are ignored.
void AddScan(const gazebo::physics::WorldPtr &world, const Bodies &bodies, Reader &request, Writer &answer);
}  // namespace nrp
