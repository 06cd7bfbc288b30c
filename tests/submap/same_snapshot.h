/// @file
/// Whether two snapshots are one, to the bit.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>

#include "leadline/submap/snapshot.h"

namespace leadline {

inline void expect_same(const Joint& a, const Joint& b) {
  ASSERT_EQ(a.parts().size(), b.parts().size());
  for (std::size_t i = 0; i < a.parts().size(); ++i) {
    ASSERT_EQ(a.parts()[i].key, b.parts()[i].key);
    ASSERT_EQ(a.parts()[i].value, b.parts()[i].value);
  }
  ASSERT_EQ(a.covariance(), b.covariance());
}

inline void expect_same(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.utime, b.utime);
  EXPECT_EQ(a.error, b.error);
  expect_same(a.joint, b.joint);
  ASSERT_EQ(a.features.size(), b.features.size());
  for (std::size_t i = 0; i < a.features.size(); ++i) {
    ASSERT_EQ(a.features[i].id, b.features[i].id);
    ASSERT_EQ(a.features[i].hits, b.features[i].hits);
    ASSERT_EQ(a.features[i].existence, b.features[i].existence);
  }
  EXPECT_EQ(a.next_feature, b.next_feature);
  EXPECT_EQ(a.aliases, b.aliases);
  EXPECT_EQ(a.first_returns, b.first_returns);
  EXPECT_EQ(a.current, b.current);
  EXPECT_EQ(a.in_use, b.in_use);
  EXPECT_EQ(a.next_gate, b.next_gate);
  EXPECT_EQ(a.links.size(), b.links.size());
  ASSERT_EQ(a.submaps.size(), b.submaps.size());
  for (std::size_t k = 0; k < a.submaps.size(); ++k) {
    expect_same(a.submaps[k]->thaw(), b.submaps[k]->thaw());
    EXPECT_EQ(a.submaps[k]->visits(), b.submaps[k]->visits());
  }
}

}  // namespace leadline
