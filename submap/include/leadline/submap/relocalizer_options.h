/// @file
/// How a lost vehicle looks for its place.
#pragma once

#include "leadline/core/angle.h"
#include "leadline/core/options.h"

namespace leadline {

struct RelocalizerOptions {
  int features = 16;           ///< that were heard of late are used, those known best
  int seeds = 12'000;          ///< pairs of the map that are tried at most
  int checks = 64;             ///< places that are looked at closely at most
  int places = 16;             ///< that are told at most
  int pairs = 200'000;         ///< of the map, of each kind, that are kept at most, the shortest
  double reach = 20.0;         ///< [m]; what lies farther apart in the map is no pair
  double margin = 10.0;        ///< [m]; the vehicle may be so far outside the map
  double new_share = 0.2;      ///< of what is heard, that the map does not hold
  double missed_share = 0.2;   ///< of what the map holds and might have been heard, that was not
  double point_density = 0.0;  ///< [1/m^2], of points in the world; 0: as in the map
  double wall_density = 0.0;   ///< [1/(m rad)], the same of walls
  double label_error = 0.01;   ///< probability that a label is wrong
  double wall_reach = 5.0;     ///< [m]; a wall may go on so far beyond what was seen of it
  double least_odds = 1000.0;  ///< of the map over elsewhere, below which nothing is found
  double sure = 0.99;          ///< probability from which a place is found
  double found_sigma = 1.0;    ///< [m], the most in any direction of a place that is found
  double same_place = 0.2;     ///< [m], standard deviation by which poses of one place may differ
  double same_heading = from_degrees(3.0);  ///< [rad], the same
};

void visit(OptionVisitor& visitor, RelocalizerOptions& options);

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does.
void validate(const RelocalizerOptions& options);

/// When a Slam looks for the place of its vehicle. A search is made within a step, which allocates then and
/// takes longer (docs/theory.md, Lost and found).
struct RelocalizationOptions {
  bool when_lost = false;  ///< looks by itself: is it lost, does it begin wide? Else when it is told to
  double wide = 5.0;       ///< [m], from which standard deviation of a beginning on
  double lost_for = 10.0;  ///< [s] for which readings and map have contradicted the estimate
  double period = 1.0;     ///< [s], between two searches
  double memory = 120.0;   ///< [s]; what was heard before is not used
  int agree = 3;           ///< searches in a row that must find the same place
  RelocalizerOptions search;
};

void visit(OptionVisitor& visitor, RelocalizationOptions& options);

}  // namespace leadline
