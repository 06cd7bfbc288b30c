/// @file
/// All measurements of an instant against all features.
#pragma once

#include <concepts>
#include <span>

#include "leadline/core/association/match.h"
#include "leadline/core/association/nearest_neighbour.h"

namespace leadline {

/// The measurements of an instant and what they may come from. The table keeps the innovations of the
/// candidates it has named last, so that what is settled need not be predicted again.
template <class T>
concept AssignmentTable = requires(T& table, int measurement, const Match& match) {
  { table.size() } -> std::convertible_to<int>;                                          // measurements
  { table.candidates(measurement) } -> std::convertible_to<std::span<const Candidate>>;  // of one of them
  table.settle(measurement, match);  // takes the answer in; candidates named later know of it
};

/// Settles every measurement of @p table: feature, new or clutter. One after the other, each against the map
/// as those before it have left it.
template <Associator A, AssignmentTable T>
void assign(const A& associator, T& table) {
  for (int measurement = 0; measurement < table.size(); ++measurement)
    table.settle(measurement, associator(table.candidates(measurement)));
}

}  // namespace leadline
