#pragma once
// The tests, in the order of the list that `drench test` prints.

#include "laboratory/laboratory.hpp"

namespace drench {

StandardTest vertical_wicking_test();
StandardTest horizontal_wicking_test();
StandardTest drop_absorbency_test();
StandardTest spray_test();
StandardTest impact_penetration_test();
StandardTest spray_impact_test();
StandardTest hydrostatic_head_test();
StandardTest strike_through_test();
StandardTest wetback_test();
StandardTest drying_rate_test();
StandardTest drape_test();
StandardTest tensile_test();
StandardTest cantilever_test();

}  // namespace drench
