// Pinocchio's dynamics of the same chain: the reference of the recursion in tests, and the control measurement that
// `palpate bench loop` prints next to the time of a cycle.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

namespace palpate::reference {

class AllTerms {
 public:
  /// Throws as Arm::from_urdf().
  AllTerms(const std::string& xml, const std::string& base_frame, const std::string& tip_frame);
  AllTerms(AllTerms&&) noexcept;
  AllTerms& operator=(AllTerms&&) noexcept;
  ~AllTerms();

  /// Pinocchio's computeAllTerms at (q, v), n numbers each.
  void compute(const Eigen::VectorXd& q, const Eigen::VectorXd& v) noexcept;
  [[nodiscard]] Eigen::MatrixXd M() const;     ///< inertia, symmetric (n, n)
  [[nodiscard]] Eigen::VectorXd bias() const;  ///< C v + G (n)
  [[nodiscard]] Eigen::VectorXd G() const;     ///< gravity torque (n)
  [[nodiscard]] Eigen::MatrixXd J() const;     ///< at the tip in base axes, linear rows over angular rows (6, n)
  [[nodiscard]] Eigen::Index n() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::reference
