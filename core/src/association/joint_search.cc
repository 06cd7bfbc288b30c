#include "leadline/core/association/joint_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"

namespace leadline {

namespace {

/// Below the likeliest, in logarithms: what no sum notices.
constexpr double kNegligible = 25.0;

}  // namespace

JointSearch::JointSearch(const Limits& limits)
    : limits_(limits),
      row_size_(2 * static_cast<std::size_t>(limits.items)),
      S_(Eigen::MatrixXd::Zero(2 * limits.options, 2 * limits.options)) {
  const auto items = static_cast<std::size_t>(limits.items),
             options = static_cast<std::size_t>(limits.options);
  const auto hypotheses = static_cast<std::size_t>(limits.hypotheses);
  gates_.push_back(std::numeric_limits<double>::infinity());
  for (std::size_t rows = 1; rows <= row_size_; ++rows)
    gates_.push_back(chi_square_quantile(limits.gate, static_cast<double>(rows)));
  items_.reserve(items);
  options_.reserve(options);
  order_.reserve(items);
  choices_.reserve(items);
  kept_.reserve(hypotheses);
  extended_.reserve(hypotheses * (options + 1));
  nodes_.reserve(items * hypotheses);
  factors_.resize(items * hypotheses * 2 * row_size_);
  lineage_.reserve(items);
  scratch_rows_.resize(2 * row_size_);
}

bool JointSearch::has_room(int options) const {
  return items() < limits_.items && this->options() + options <= limits_.options;
}

void JointSearch::clear() {
  items_.clear();
  options_.clear();
}

int JointSearch::add_item(double log_alone) {
  items_.push_back({log_alone, options(), 0, 1.0});
  return items() - 1;
}

int JointSearch::add_option(int target, int dof, const Vector<2>& residual, double log_weight) {
  options_.push_back({items() - 1, target, dof, log_weight, residual, 0.0});
  ++items_.back().options;
  return options() - 1;
}

void JointSearch::set_covariance(int a, int b, const Matrix<2, 2>& S) {
  S_.block<2, 2>(2 * a, 2 * b) = S;
  S_.block<2, 2>(2 * b, 2 * a) = S.transpose();
}

void JointSearch::solve() {
  order_.resize(items_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::sort(order_, {},
                    [&](int i) { return std::tuple(items_[static_cast<std::size_t>(i)].options, i); });
  nodes_.clear();
  kept_.assign(1, {});
  int rows_to_come = 2 * items();
  for (const int item : order_) {
    rows_to_come -= 2;
    extended_.clear();
    take(item, rows_to_come);
    keep_likeliest();
  }
  answer();
}

/// Every hypothesis goes on with each option of the item, and with none.
void JointSearch::take(int item, int rows_to_come) {
  const Item& taken = items_[static_cast<std::size_t>(item)];
  for (const Hypothesis& before : kept_) {
    Hypothesis& alone = extended_.emplace_back(before);
    alone.option = kNone;
    alone.score += taken.log_alone;
    recall(before.node);
    for (int option = taken.first; option < taken.first + taken.options; ++option) {
      const Option& chosen = options_[static_cast<std::size_t>(option)];
      Node node;
      if (is_taken(chosen.target) || !whiten(option, node, scratch_rows_.data())) continue;
      Hypothesis after{before.node, option, before.rows + chosen.dof, before.gamma,
                       before.score + chosen.log_weight};
      double log_density = -0.5 * chosen.dof * std::log(2.0 * kPi);
      for (int r = 0; r < chosen.dof; ++r) {
        const auto k = static_cast<std::size_t>(r);
        after.gamma += node.white[k] * node.white[k];
        log_density -= 0.5 * node.white[k] * node.white[k] +
                       std::log(scratch_rows_[k * row_size_ + static_cast<std::size_t>(node.row + r)]);
      }
      after.score += log_density;
      // What nothing that is still to come can bring through the gate.
      const int most_rows = after.rows + rows_to_come;
      if (after.gamma < gates_[static_cast<std::size_t>(most_rows)]) extended_.push_back(after);
    }
  }
}

/// Gathers the nodes of a hypothesis.
void JointSearch::recall(int node) {
  lineage_.clear();
  for (; node != kNone; node = nodes_[static_cast<std::size_t>(node)].previous) lineage_.push_back(node);
  std::ranges::reverse(lineage_);
}

bool JointSearch::is_taken(int target) const {
  return std::ranges::any_of(
      lineage_, [&](int node) { return target_of(nodes_[static_cast<std::size_t>(node)].option) == target; });
}

/// The node of an option after those of the lineage, and its rows of the factor.
/// @return false if the covariance is not positive definite.
bool JointSearch::whiten(int option, Node& node, double* rows) const {
  node.option = option;
  node.previous = lineage_.empty() ? kNone : lineage_.back();
  const int dof = dof_of(option);
  const auto size = static_cast<Eigen::Index>(row_size_);
  for (int r = 0; r < dof; ++r) {
    Eigen::Map<Eigen::RowVectorXd> row(rows + static_cast<std::size_t>(r) * row_size_, size);
    double rest = options_[static_cast<std::size_t>(option)].residual[r];
    int k = 0;
    const auto eliminate = [&](double covariance, const double* of, double white) {
      const Eigen::Map<const Eigen::RowVectorXd> other(of, size);
      row[k] = (covariance - row.head(k).dot(other.head(k))) / other[k];
      rest -= row[k] * white;
      ++k;
    };
    for (const int before : lineage_) {
      const Node& chosen = nodes_[static_cast<std::size_t>(before)];
      const double* factor = factors_.data() + static_cast<std::size_t>(before) * 2 * row_size_;
      for (int q = 0; q < dof_of(chosen.option); ++q)
        eliminate(S_(2 * option + r, 2 * chosen.option + q), factor + static_cast<std::size_t>(q) * row_size_,
                  chosen.white[static_cast<std::size_t>(q)]);
    }
    if (r == 0) node.row = k;
    for (int q = 0; q < r; ++q)
      eliminate(S_(2 * option + r, 2 * option + q), rows + static_cast<std::size_t>(q) * row_size_,
                node.white[static_cast<std::size_t>(q)]);
    const double variance = S_(2 * option + r, 2 * option + r) - row.head(k).squaredNorm();
    if (!(variance > 0.0)) return false;
    row[k] = std::sqrt(variance);
    node.white[static_cast<std::size_t>(r)] = rest / row[k];
  }
  return true;
}

/// Those extended hypotheses that are worth going on with, each with the node of what it has chosen.
void JointSearch::keep_likeliest() {
  const auto likelier = [](const Hypothesis& a, const Hypothesis& b) {
    return std::tuple(-a.score, a.node, a.option) < std::tuple(-b.score, b.node, b.option);
  };
  const double best = std::ranges::max(extended_, {}, &Hypothesis::score).score;
  std::erase_if(extended_, [&](const Hypothesis& h) { return !(h.score >= best - kNegligible); });
  const auto most = static_cast<std::ptrdiff_t>(limits_.hypotheses);
  if (std::ssize(extended_) > most) {
    std::ranges::nth_element(extended_, extended_.begin() + most, likelier);
    extended_.erase(extended_.begin() + most, extended_.end());
  }
  kept_.clear();
  for (Hypothesis hypothesis : extended_) {
    if (hypothesis.option != kNone) {
      recall(hypothesis.node);
      Node& node = nodes_.emplace_back();
      whiten(hypothesis.option, node, rows_of(nodes_.size() - 1));
      hypothesis.node = static_cast<int>(nodes_.size()) - 1;
    }
    kept_.push_back(hypothesis);
  }
}

void JointSearch::answer() {
  const auto passes = [&](const Hypothesis& h) { return h.gamma < gates_[static_cast<std::size_t>(h.rows)]; };
  const Hypothesis* best = nullptr;
  for (const Hypothesis& hypothesis : kept_)
    if (passes(hypothesis) && (!best || hypothesis.score > best->score)) best = &hypothesis;
  choices_.assign(items_.size(), kNone);
  if (!best) return;

  double sum = 0.0;
  for (Option& option : options_) option.posterior = 0.0;
  for (const Hypothesis& hypothesis : kept_) {
    if (!passes(hypothesis)) continue;
    const double share = std::exp(hypothesis.score - best->score);
    sum += share;
    recall(hypothesis.node);
    for (const int node : lineage_)
      options_[static_cast<std::size_t>(nodes_[static_cast<std::size_t>(node)].option)].posterior += share;
  }
  for (Item& item : items_) item.posterior = 1.0;
  for (Option& option : options_) {
    option.posterior /= sum;
    double& alone = items_[static_cast<std::size_t>(option.item)].posterior;
    alone = std::max(alone - option.posterior, 0.0);
  }
  recall(best->node);
  for (const int node : lineage_) {
    const int option = nodes_[static_cast<std::size_t>(node)].option;
    choices_[static_cast<std::size_t>(item_of(option))] = option;
  }
}

}  // namespace leadline
