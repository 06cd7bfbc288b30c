#include "apps/recordings/log_pass.h"

#include <fmt/format.h>

#include <variant>

#include "apps/recordings/ignore.h"
#include "apps/support/interrupt.h"

namespace leadline::app {

LogPass::LogPass(const std::filesystem::path& path, const LogSelection& selection, Channels channels,
                 LogReport* report)
    : selection_(selection),
      truth_channel_(std::string(selection.prefix) + std::string(message_format<truth_t>().channel)),
      channels_(channels),
      report_(report),
      event_(path) {}

std::optional<Content> LogPass::next() {
  while (event_.next()) {
    throw_if_interrupted();
    if (report_) ++report_->events;
    if (!is_wanted()) continue;
    const Receiver receive = receiver_of(event_.channel(), selection_.prefix);
    if (!receive)
      pass_over();
    else if (std::optional<Content> said = take(receive))
      return said;
  }
  if (report_) {
    report_->damage = event_.damage();
    report_->bytes = event_.size();
  }
  return std::nullopt;
}

bool LogPass::is_wanted() const {
  return channels_ == Channels::all || (channels_ == Channels::truth) == (event_.channel() == truth_channel_);
}

std::optional<Content> LogPass::take(Receiver receive) {
  const std::string channel(event_.channel());
  if (is_ignored(channel, selection_.ignore)) return std::nullopt;
  const auto received = receive(event_.data());
  if (const auto* rejection = std::get_if<Rejection>(&received)) {
    if (report_) report_->survey.refuse(channel, rejection->text);
    refuse(*rejection);
    return std::nullopt;
  }
  const Message& message = std::get<Message>(received);
  const std::string stream = std::visit([&](const auto& m) { return stream_of(channel, m); }, message);
  if (is_ignored(stream, selection_.ignore)) return std::nullopt;
  if (report_) report_->survey.add(stream, message);
  Content said = content(message, selection_.sensors);
  if (const auto* rejection = std::get_if<Rejection>(&said)) {
    refuse(*rejection);
    return std::nullopt;
  }
  if (report_) std::visit([&](const auto& m) { count_lost(stream, m.utime, m.seq); }, message);
  if (auto* instant = std::get_if<Instant>(&said))
    return corrected(std::move(*instant), selection_.corrections);
  return said;
}

/// On a channel that is not read: what it is, the first message tells.
void LogPass::pass_over() {
  if (!report_) return;
  ++report_->foreign;
  const std::string channel(event_.channel());
  if (is_ignored(channel, selection_.ignore)) return;
  const auto known = others_.find(channel);
  const MessageFormat* format = known != others_.end() ? known->second : format_of(event_.data());
  others_.try_emplace(channel, format);
  report_->survey.pass_over(channel, format, event_.timestamp());
}

void LogPass::count_lost(const std::string& stream, std::int64_t utime, std::int64_t seq) {
  auto& [gaps, last] = counted_[stream];
  if (std::exchange(last, std::pair(utime, seq)) == std::pair(utime, seq)) return;  // it came twice
  report_->lost += gaps.missing_before(seq);
  if (gaps.has_two_senders()) report_->two_senders.insert(stream);
}

void LogPass::refuse(const Rejection& rejection) {
  if (report_)
    report_->refuse(rejection.reason, 1,
                    fmt::format("byte {}: {}: {}", event_.position(), event_.channel(), rejection.text));
}

}  // namespace leadline::app
