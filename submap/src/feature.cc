#include "leadline/submap/feature.h"

#include "leadline/vehicle/elapsed.h"

namespace leadline {

void Feature::shift_clock(std::int64_t shift) {
  last_seen = after_setting(last_seen, shift);
  existence.shift_clock(shift);
}

}  // namespace leadline
