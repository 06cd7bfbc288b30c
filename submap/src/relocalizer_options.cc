#include "leadline/submap/relocalizer_options.h"

#include "leadline/core/option_checker.h"

namespace leadline {

void visit(OptionVisitor& visitor, RelocalizerOptions& options) {
  visitor.integer("features", options.features, {1, 64},
                  {"", "of those heard of late so many are used, those known best"});
  visitor.integer("seeds", options.seeds, {1, 10'000'000}, {"", "pairs of the map that are tried at most"});
  visitor.integer("checks", options.checks, {1, 10'000}, {"", "places that are looked at closely at most"});
  visitor.integer("places", options.places, {1, 1000}, {"", "places that are told at most"});
  visitor.integer("pairs", options.pairs, {1, 10'000'000},
                  {"", "of the map so many are kept of each kind, the shortest"});
  visitor.number("reach_m", options.reach, {0.1, 1000.0},
                 {"m", "what lies farther apart in the map is no pair"});
  visitor.number("margin_m", options.margin, {0.1, 10'000.0},
                 {"m", "the vehicle may be so far outside the map"});
  visitor.number("new_share", options.new_share, {0.001, 0.999},
                 {"", "of what is heard, that the map does not hold"});
  visitor.number("missed_share", options.missed_share, {0.001, 1.0},
                 {"", "of what the map holds and might have been heard, that was not"});
  visitor.number("point_density", options.point_density, {0.0, 1e4},
                 {"1/m^2", "points in the world; 0: as in the map"});
  visitor.number("wall_density", options.wall_density, {0.0, 1e4},
                 {"1/(m rad)", "walls in the world; 0: as in the map"});
  visitor.number("label_error", options.label_error, {0.0, 0.5}, {"", "probability that a label is wrong"});
  visitor.number("wall_reach_m", options.wall_reach, {0.0, 1000.0},
                 {"m", "a wall may go on so far beyond what was seen of it"});
  visitor.number("least_odds", options.least_odds, {1.0, 1e12},
                 {"", "of the map over elsewhere, below which nothing is found"});
  visitor.number("sure", options.sure, {0.5, 1.0}, {"", "probability from which a place is found"});
  visitor.number("found_sigma_m", options.found_sigma, {0.001, 1e4},
                 {"m", "the most in any direction of a place that is found"});
  visitor.number("same_place_m", options.same_place, {0.001, 100.0},
                 {"m", "standard deviation by which poses of one place may differ"});
  visitor.number("same_heading_deg", options.same_heading, {0.01, 90.0},
                 {"deg", "the same of their headings"});
}

void validate(const RelocalizerOptions& options) {
  RelocalizerOptions copy = options;
  OptionChecker checker;
  visit(checker, copy);
}

void visit(OptionVisitor& visitor, RelocalizationOptions& options) {
  visitor.flag(
      "when_lost", options.when_lost,
      {"",
       "looks by itself for its place: lost, put elsewhere, or where it begins wide; `false`: when it "
       "is told to. A search is made within a step"});
  visitor.number("wide_m", options.wide, {0.01, 1e6},
                 {"m", "standard deviation of the position from which a beginning in a map is wide"});
  visitor.number("lost_for_s", options.lost_for, {0.0, 1e6},
                 {"s", "for which readings and map have contradicted the estimate: then it is lost"});
  visitor.number("period_s", options.period, {0.01, 1e6}, {"s", "between two searches"});
  visitor.number("memory_s", options.memory, {0.1, 1e6}, {"s", "what was heard before is not used"});
  visitor.integer("agree", options.agree, {1, 1000}, {"", "searches in a row that must find the same place"});
  visit(visitor, options.search);
}

}  // namespace leadline
