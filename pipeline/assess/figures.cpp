#include "pipeline/assess/figures.h"

#include <algorithm>
#include <cassert>

namespace beatlas::assess {

Limits LimitSet::of(Structure structure) const {
  Limits out = all;
  const auto found = structures.find(structure);
  if (found == structures.end()) return out;
  for (const LimitName& limit : kLimitNames) {
    if (found->second.*limit.member) out.*limit.member = found->second.*limit.member;
  }
  return out;
}

const LimitName& name_of(LimitMember member) {
  const auto* found = std::find_if(kLimitNames.begin(), kLimitNames.end(),
                                   [&](const LimitName& limit) { return limit.member == member; });
  assert(found != kLimitNames.end());
  return *found;
}

}  // namespace beatlas::assess
