/// @file
/// Long sequences of which a piece is in memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "apps/support/scratch_file.h"

namespace leadline::app {

/// A sequence that grows at its end and is read mostly in order: a block at its end and one that is being
/// read are in memory, the others in a file. What fits one block touches no file. Reading, const or not, is
/// for one thread at a time.
/// @tparam T is what its bytes say: no pointer, nothing to destroy.
template <class T>
class Spool {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  // The standard's names. NOLINTBEGIN(readability-identifier-naming)
  class Iterator;
  using value_type = T;
  using iterator = Iterator;
  using const_iterator = Iterator;
  // NOLINTEND(readability-identifier-naming)

  static constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
  static constexpr std::size_t kBlock = std::max<std::size_t>(kBlockBytes / sizeof(T), 1);  ///< items

  /// Gives items by value.
  class Iterator {
   public:
    // NOLINTBEGIN(readability-identifier-naming)
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using iterator_concept = std::forward_iterator_tag;
    // NOLINTEND(readability-identifier-naming)

    Iterator() = default;
    Iterator(const Spool& spool, std::size_t i) : spool_(&spool), i_(i) {}
    T operator*() const { return (*spool_)[i_]; }
    Iterator& operator++() {
      ++i_;
      return *this;
    }
    Iterator operator++(int) { return {*spool_, i_++}; }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.i_ == b.i_; }

   private:
    const Spool* spool_ = nullptr;
    std::size_t i_ = 0;
  };

  Spool() = default;
  Spool(std::initializer_list<T> items) : Spool(std::span(items)) {}
  explicit Spool(std::span<const T> items) {
    for (const T& item : items) push_back(item);
  }

  /// @throws std::runtime_error as ScratchFile does; so does reading.
  void push_back(const T& item) {
    if (end_.size() == kBlock) put_aside();
    end_.push_back(item);
  }

  std::size_t size() const { return filed_ + end_.size(); }
  bool empty() const { return size() == 0; }
  T front() const { return (*this)[0]; }
  /// Precondition of these: not empty.
  const T& back() const { return end_.back(); }
  T& back() { return end_.back(); }

  T operator[](std::size_t i) const {
    if (i >= filed_) return end_[i - filed_];
    if (i < block_begin_ || i >= block_begin_ + block_.size()) fetch(i - i % kBlock);
    return block_[i - block_begin_];
  }

  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }

 private:
  void put_aside() {
    if (!file_) file_ = std::make_unique<ScratchFile>();
    file_->append(std::as_bytes(std::span(end_)));
    filed_ += end_.size();
    end_.clear();
  }

  void fetch(std::size_t begin) const {
    block_.resize(kBlock);
    block_begin_ = begin;
    file_->read(begin * sizeof(T), std::as_writable_bytes(std::span(block_)));
  }

  std::vector<T> end_;  // not empty if anything is there
  std::size_t filed_ = 0;
  std::unique_ptr<ScratchFile> file_;
  mutable std::vector<T> block_;
  mutable std::size_t block_begin_ = 0;
};

}  // namespace leadline::app
