#pragma once
// The parts of a report. Each takes one run, or two to set beside each other, and returns HTML; "" when it has nothing
// to show.

#include <string>
#include <vector>

#include "report/run_record.hpp"

namespace drench {

using Runs = std::vector<RunRecord>;  // one or two

std::string failure_section(const Runs& runs);     ///< why it failed, where, and what to change
std::string summary_section(const Runs& runs);     ///< scene, program, device, steps, times
std::string difference_section(const Runs& runs);  ///< two runs: their numbers and their scenes
std::string warning_section(const Runs& runs);
std::string picture_section(const Runs& runs);
std::string mass_section(const Runs& runs);   ///< the account of liquid
std::string solve_section(const Runs& runs);  ///< iterations and errors beside the scene's tolerances
std::string stage_section(const Runs& runs);  ///< where the time goes
std::string energy_section(const Runs& runs);
std::string motion_section(const Runs& runs);  ///< speeds, stretch, length of steps, number of particles
std::string scene_section(const Runs& runs);   ///< resolved
std::string version_section(const Runs& runs);

/// "A: " and "B: " where there are two runs, else "".
std::string letter(const Runs& runs, std::size_t run);

/// A heading with the run's name where there are two, else "".
std::string run_heading(const Runs& runs, std::size_t run);

}  // namespace drench
