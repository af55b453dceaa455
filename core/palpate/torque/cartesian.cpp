#include "palpate/torque/cartesian.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace palpate::torque {
namespace {

constexpr double kLength = 0.1;  // [m] that makes a rotational inertia a mass

}  // namespace

template <int m>
Cartesian<m> cartesian(const arm::Dynamics& d, const JointVector& rotor, const JointVector& G, Eigen::Index joints,
                       double heaviest) noexcept {
  using Square = Eigen::Matrix<double, m, m>;
  using Column = Eigen::Matrix<double, m, 1>;
  using Tall = Eigen::Matrix<double, Eigen::Dynamic, m, 0, kMaxJoints, m>;
  Column weight = Column::Ones();
  if constexpr (m == 6) weight.template tail<3>().setConstant(kLength);

  JointMatrix M = d.M.topLeftCorner(joints, joints);
  M.diagonal() += rotor.head(joints);
  const Eigen::LLT<JointMatrix> cholesky(M);
  const Tall Jt = d.J.topLeftCorner(m, joints).transpose();
  const Tall Y = cholesky.solve(Jt);  // M^-1 J^T
  const Square A = weight.asDiagonal() * Square(Jt.transpose().lazyProduct(Y)) * weight.asDiagonal();

  Cartesian<m> c;
  const Eigen::LLT<Square> factors(A);
  Square inverse = factors.solve(Square::Identity());
  if (factors.info() != Eigen::Success ||
      !(inverse.trace() <= heaviest)) {  // below it, no eigenvalue is above it, and there is nothing to cut
    const Eigen::SelfAdjointEigenSolver<Square> eigen(A);
    const Column light = eigen.eigenvalues().cwiseMax(1.0 / heaviest);
    c.singular = !(eigen.eigenvalues()[0] >= 1.0 / heaviest);
    inverse = eigen.eigenvectors() * light.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  }
  c.Lambda = weight.asDiagonal() * inverse * weight.asDiagonal();
  const JointVector Cv = d.bias.head(joints) - G.head(joints);
  c.Gamma_v = c.Lambda * (Column(Y.transpose().lazyProduct(Cv)) - d.Jdot_v.head<m>());
  c.eta = c.Lambda * Column(Y.transpose().lazyProduct(G.head(joints)));
  return c;
}

template Cartesian<3> cartesian<3>(const arm::Dynamics&, const JointVector&, const JointVector&, Eigen::Index,
                                   double) noexcept;
template Cartesian<6> cartesian<6>(const arm::Dynamics&, const JointVector&, const JointVector&, Eigen::Index,
                                   double) noexcept;

}  // namespace palpate::torque
