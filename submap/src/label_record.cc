#include "leadline/submap/label_record.h"

#include <algorithm>
#include <tuple>

namespace leadline {

LabelRecord::LabelRecord() {
  refusals_.reserve(kMost);
  doubts_.reserve(kMost);
}

void LabelRecord::refuse(int sensor, int label) {
  const auto of = std::ranges::find_if(
      refusals_, [&](const Refusals& r) { return r.sensor == sensor && r.label == label; });
  if (of != refusals_.end()) {
    ++of->count;
    return;
  }
  if (std::ssize(refusals_) == kMost)
    refusals_.erase(std::ranges::min_element(refusals_, {}, &Refusals::count));
  refusals_.push_back({sensor, label, 1});
}

void LabelRecord::count(const Vote& vote) {
  bool is_counted = false;
  for (Doubt& doubt : doubts_) {
    if (doubt.feature != vote.feature) continue;
    ++doubt.all;
    if (doubt.label == vote.label) {
      ++doubt.votes;
      doubt.strays += vote.elsewhere;
      is_counted = true;
    } else {
      if (doubt.usual == Sighting::kUnknown) doubt.usual = vote.label;
      doubt.usual_votes += doubt.usual == vote.label;
    }
  }
  const bool is_strange = vote.elsewhere || (vote.usual != Sighting::kUnknown && vote.usual != vote.label);
  if (is_counted || !is_strange) return;
  if (std::ssize(doubts_) == kMost)
    doubts_.erase(std::ranges::min_element(doubts_, {}, [](const Doubt& doubt) { return doubt.weight(); }));
  const int usual = vote.usual == vote.label ? Sighting::kUnknown : vote.usual;
  doubts_.push_back({.feature = vote.feature,
                     .label = vote.label,
                     .usual = usual,
                     .votes = 1,
                     .strays = vote.elsewhere,
                     .all = 1});
}

void LabelRecord::forget(int feature) {
  std::erase_if(doubts_, [&](const Doubt& doubt) { return doubt.feature == feature; });
}

std::vector<LabelRecord::Finding> LabelRecord::findings() const {
  std::vector<Finding> findings;
  for (const Doubt& doubt : doubts_) {
    const auto& [least, most] = std::minmax(doubt.label, doubt.usual);
    if (doubt.names_two_places())
      findings.push_back({Finding::Kind::two_places, doubt.label, Sighting::kUnknown});
    else if (doubt.is_one_place())
      findings.push_back({Finding::Kind::one_place, least, most});
  }
  std::ranges::sort(findings, {}, [](const Finding& f) { return std::tuple(f.kind, f.label, f.other); });
  findings.erase(std::unique(findings.begin(), findings.end()), findings.end());
  return findings;
}

}  // namespace leadline
