#include "apps/recordings/csv_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "apps/recordings/row_order.h"

namespace leadline::app {
namespace {

std::string_view row_or_rows(std::size_t count) { return count == 1 ? "row" : "rows"; }

}  // namespace

template <class T>
CsvStream<T>::CsvStream(std::filesystem::path path, CsvFormat<T> format, bool skip_bad)
    : path_(path.string()),
      format_(std::move(format)),
      skip_bad_(skip_bad),
      csv_(path, format_.columns, format_.more) {
  Times times = read_times();
  put_in_order(times);
  rows_ = times.utimes.size();
  if (rows_ == 0) return;
  first_ = times.utimes.front();
  last_ = times.utimes.back();
  if (!format_.scans) look_for_equal(times);
}

template <class T>
typename CsvStream<T>::Times CsvStream<T>::read_times() {
  CsvReader csv(path_, format_.columns, format_.more);
  Times times;
  for (;;) {
    try {
      if (!csv.next()) return times;
      const std::int64_t utime = csv.utime();
      times.utimes.push_back(utime);
      times.lines.push_back(csv.line());
    } catch (const BadRow&) {
      if (!skip_bad_) throw;  // else it is counted when it is read
    }
  }
}

template <class T>
void CsvStream<T>::put_in_order(Times& times) {
  const RowOrder order = order_of(times.utimes);
  if (order.moved.empty() && order.astray.empty()) return;
  reach_ = order.reach;
  if (!order.moved.empty())
    notes_.push_back(fmt::format("{}: not in the order of time and put in its place: {} {} in all",
                                 at(times.lines[order.moved.front()]), order.moved.size(),
                                 row_or_rows(order.moved.size())));
  if (!order.astray.empty()) {
    const std::size_t i = order.astray.front();
    const std::string why =
        fmt::format("{}: the time is {:.6f}, {} {} not in the order of time: was a clock set?",
                    at(times.lines[i]), 1e-6 * static_cast<double>(times.utimes[i]), order.astray.size(),
                    order.astray.size() == 1 ? "row is" : "rows are");
    if (!skip_bad_) throw BadRow(why);
    for (const std::size_t row : order.astray) skip(times.lines[row], why);
    astray_ = skipped_;
  }
  Times kept;
  for (std::size_t i = 0; i < times.utimes.size(); ++i) {
    if (astray_.contains(times.lines[i])) continue;
    kept.utimes.push_back(times.utimes[i]);
    kept.lines.push_back(times.lines[i]);
  }
  times = std::move(kept);
  if (reach_ == 0) return;
  std::vector<std::size_t> place(times.utimes.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = i;
  std::ranges::stable_sort(place, {}, [&](std::size_t i) { return times.utimes[i]; });
  Times sorted;
  for (const std::size_t i : place) {
    sorted.utimes.push_back(times.utimes[i]);
    sorted.lines.push_back(times.lines[i]);
  }
  times = std::move(sorted);
}

template <class T>
void CsvStream<T>::look_for_equal(const Times& times) {
  std::size_t count = 0, line = 0;
  for (std::size_t i = 1; i < rows_; ++i) {
    if (times.utimes[i] != times.utimes[i - 1]) continue;
    if (count++ == 0) line = times.lines[i];
  }
  if (count == 0) return;
  if (first_ == last_ || count > std::max<std::size_t>(1, rows_ / 100))
    throw std::runtime_error(fmt::format(
        "{}: the time of the row before again, so it is with {} of {} rows: times must differ, in the sixth "
        "decimal at least",
        at(line), count, rows_));
  notes_.push_back(fmt::format("{}: the time of the row before again, {}: {} {} in all", at(line),
                               format_.join ? "what both say is added" : "the first value is used", count,
                               row_or_rows(count)));
}

template <class T>
std::optional<T> CsvStream<T>::next() {
  fill_window();
  if (window_.empty()) {
    if (used_ == 0 && !skipped_.empty())
      throw std::runtime_error(fmt::format("{}: no row can be used, the first: {}", path_, first_skipped_));
    return std::nullopt;
  }
  T result = std::move(window_.front());
  window_.erase(window_.begin());
  for (fill_window(); !window_.empty() && window_.front().utime == result.utime; fill_window()) {
    if (format_.join) format_.join(result, window_.front());
    window_.erase(window_.begin());
  }
  return result;
}

template <class T>
void CsvStream<T>::fill_window() {
  T row;
  while (window_.size() <= reach_ && read_row(row)) {
    window_.insert(std::ranges::upper_bound(window_, row.utime, {}, &T::utime), std::move(row));
    row = {};
  }
}

template <class T>
bool CsvStream<T>::read_row(T& row) {
  for (;;) {
    try {
      if (!csv_.next()) return false;
      if (astray_.contains(csv_.line())) continue;
      row = {};
      row.utime = csv_.utime();
      format_.put(csv_, row);
      ++used_;
      return true;
    } catch (const BadRow& bad) {
      if (!skip_bad_) throw;
      skip(csv_.line(), bad.what());
    }
  }
}

template <class T>
void CsvStream<T>::skip(std::size_t line, const std::string& why) {
  if (skipped_.empty()) first_skipped_ = why;
  skipped_.insert(line);
}

template <class T>
std::vector<std::string> CsvStream<T>::notes() const {
  std::vector<std::string> notes = notes_;
  if (rows_ == 0 && skipped_.empty()) notes.push_back(fmt::format("{}: has no row", path_));
  if (!skipped_.empty())
    notes.push_back(fmt::format("{}: {} {} of {} skipped, the first: {}", path_, skipped_.size(),
                                row_or_rows(skipped_.size()), skipped_.size() + used_, first_skipped_));
  return notes;
}

template <class T>
std::string CsvStream<T>::at(std::size_t line) const {
  return fmt::format("{}:{}", path_, line);
}

template class CsvStream<Instant>;
template class CsvStream<Truth>;

}  // namespace leadline::app
