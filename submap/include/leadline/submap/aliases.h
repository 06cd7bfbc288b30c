/// @file
/// Identities that features had before they were joined with others.
#pragma once

#include <span>
#include <vector>

namespace leadline {

/// An identity that was lost when its feature was joined with another one.
struct Alias {
  int lost = 0;  ///< id
  int kept = 0;  ///< id of the object now

  friend bool operator==(const Alias&, const Alias&) = default;
};

/// Features that were joined are one object, known by several ids, of which one is in use. No entry leads to
/// an id that is lost itself, so there are no chains and no cycles.
///
/// A submap that the vehicle has left may still hold an object under an id that was lost elsewhere, and the
/// object may be joined once more there: whoever compares two ids resolves both.
///
/// Bounded, and does not allocate after construction.
class Aliases {
 public:
  static constexpr int kMost = 1024;  ///< the oldest makes room

  Aliases();

  /// The object of @p lost is that of @p kept, and is called as that is.
  void join(int lost, int kept);

  /// What the object is called now that was @p id once; @p id itself where nothing is known of it.
  int resolve(int id) const;

  /// In the order in which they were lost.
  std::span<const Alias> all() const { return entries_; }

  /// Goes on with what another has given. Precondition: as validate(snapshot, options) wants it.
  void restore(std::span<const Alias> entries) { entries_.assign(entries.begin(), entries.end()); }

 private:
  std::vector<Alias> entries_;
};

}  // namespace leadline
