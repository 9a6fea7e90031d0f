// The contacts of a world: how firm they are, and those of the last step.
#pragma once

#include "bodies.hh"

namespace nrp
{
/// Make all contacts such that ODE's direct solver solves them.
///
/// It gives up, and friction with it, if contacts of rigid bodies share a load in more ways than one: so all give
/// way by a billionth of a metre for a newton, and slide by a tenth of a micrometre a second. It also turns a depth
/// into a velocity within one step, so that bodies bounce that should not: so a step removes a fifth of it.
void SteadyContacts(const gazebo::physics::WorldPtr &world);

/// Add the number of contacts between different models, and for each both links, position, normal out of the
/// second one, depth, and the force of the second on the first.
void AddContacts(const gazebo::physics::WorldPtr &world, const Bodies &bodies, Writer &answer);
}  // namespace nrp
