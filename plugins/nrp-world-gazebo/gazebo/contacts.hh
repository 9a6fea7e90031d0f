// The contacts of the last step.
#pragma once

#include "bodies.hh"

namespace nrp
{
/// Add the number of contacts between different models, and for each both links, position, normal out of the
/// second one, depth, and the force of the second on the first.
void AddContacts(const gazebo::physics::WorldPtr &world, const Bodies &bodies, Writer &answer);
}  // namespace nrp
