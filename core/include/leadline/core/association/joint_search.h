/// @file
/// Which of several things are which, decided for all of them together (after Neira and Tardos 2001, joint
/// compatibility; Reid 1979, hypotheses with a density for what is new).
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "leadline/core/linearizer.h"

namespace leadline {

/// Items (measurements of an instant, features seen of late) and for each its options (targets that it may
/// be), with the residual that each option leaves and the joint covariance of all residuals. An assignment
/// gives every item one option or none, and no target to two; its likelihood is the joint density of the
/// residuals, times the options' weights, times the density of an item that is none of its options.
///
/// Items are taken one after the other, those with the fewest options first, and the likeliest assignments of
/// those taken so far are kept: all of them while they are few, so that the answer is then exact. Members
/// take a time that the limits bound, and do not allocate after construction.
class JointSearch {
 public:
  static constexpr int kNone = -1;

  struct Limits {
    int items = 1;
    int options = 1;      ///< of all items together
    int hypotheses = 64;  ///< assignments that are kept
    double gate = 0.99;   ///< probability in (0, 1) that the right assignment passes
  };
  explicit JointSearch(const Limits& limits);

  /// Whether one more item fits, with so many options.
  bool has_room(int options) const;

  /// Forgets all items.
  void clear();

  /// @param log_alone logarithm of the density of this item where it is none of its options.
  /// Precondition: has_room() for it and its options. @return its number, from 0.
  int add_item(double log_alone);

  /// An option of the item that was added last.
  /// @param target what no other item may be as well.
  /// @param dof size of the residual, 1 or 2; entries beyond it are not used.
  /// @param log_weight added to the logarithm of the residual's density.
  /// @return its number, from 0.
  int add_option(int target, int dof, const Vector<2>& residual, double log_weight);

  /// Covariance of the residuals of options @p a and @p b, and its transpose; of all pairs of which the items
  /// and targets differ, and of each with itself.
  void set_covariance(int a, int b, const Matrix<2, 2>& S);

  int items() const { return static_cast<int>(items_.size()); }
  int options() const { return static_cast<int>(options_.size()); }
  int item_of(int option) const { return options_[static_cast<std::size_t>(option)].item; }
  int target_of(int option) const { return options_[static_cast<std::size_t>(option)].target; }

  /// Finds the likeliest assignment that passes the gate, and what is likely altogether.
  void solve();

  /// The option of an item in the likeliest assignment, or kNone.
  int choice(int item) const { return choices_[static_cast<std::size_t>(item)]; }
  /// Probability of an option, over all assignments that were kept.
  double posterior(int option) const { return options_[static_cast<std::size_t>(option)].posterior; }
  /// That an item is none of its options.
  double posterior_alone(int item) const { return items_[static_cast<std::size_t>(item)].posterior; }

 private:
  struct Item {
    double log_alone;
    int first, options;
    double posterior;
  };
  struct Option {
    int item, target, dof;
    double log_weight;
    Vector<2> residual;
    double posterior;
  };
  /// What a chosen option adds to the lower Cholesky factor of the residuals' covariance, and to the whitened
  /// residuals: its rows, which follow those of the options chosen before it.
  struct Node {
    int option = kNone;
    int previous = kNone;  ///< node of the option chosen before it
    int row = 0;           ///< its first
    std::array<double, 2> white{};
  };
  struct Hypothesis {
    int node = kNone;    ///< of the option chosen last
    int option = kNone;  ///< of the item taken last
    int rows = 0;
    double gamma = 0.0;
    double score = 0.0;  ///< log likelihood
  };

  int dof_of(int option) const { return options_[static_cast<std::size_t>(option)].dof; }
  double* rows_of(std::size_t node) { return factors_.data() + node * (2 * row_size_); }
  void take(int item, int rows_to_come);
  void recall(int node);
  bool is_taken(int target) const;
  bool whiten(int option, Node& node, double* rows) const;
  void keep_likeliest();
  void answer();

  Limits limits_;
  std::size_t row_size_;
  std::vector<double> gates_;  // of gamma, by rows
  std::vector<Item> items_;
  std::vector<Option> options_;
  Eigen::MatrixXd S_;  // by options, two rows each
  std::vector<int> order_, choices_;
  std::vector<Hypothesis> kept_, extended_;
  std::vector<Node> nodes_;
  std::vector<double> factors_;       // two rows to a node
  std::vector<int> lineage_;          // nodes of the hypothesis in hand, the first chosen first
  std::vector<double> scratch_rows_;  // of an option that is tried
};

}  // namespace leadline
