#pragma once
/// What a place of a beating heart cannot do, however a network that looks at each phase by itself
/// may see it.

#include "pipeline/prior/prior.h"

namespace beatlas::prior {

/// Makes one beat of the phases of a prior. Of the courses that a fixed place may take through the
/// beat, each is weighed by what the network says in all phases together; the probabilities of a
/// phase are then those of the courses, by their weight.
/// - Blood of the left heart (LV, left atrium, aorta) and of the right (RV, right atrium) do not
///   change places: a place holds blood of one of them alone. Either is as likely before.
/// - The base moves towards the apex as the ventricles empty and back as they fill: a place lies
///   within them (blood or wall) throughout, beyond them (atria, vessels, rest of the heart)
///   throughout, or beyond them in the phases in which the LV holds less than some volume. A third
///   of the weight before to each of these kinds, and the volumes alike.
/// @param prior stays as it is of one phase, or of a network that knows one side alone
void hold_courses(PriorCycle& prior);

}  // namespace beatlas::prior
