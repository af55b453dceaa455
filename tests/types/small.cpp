// Prints results of small expressions on random numbers, as hexadecimal numbers, which lose no bit.
#ifdef OWN
#include "palpate/types/small.hpp"
#else
#include <Eigen/Core>
#include <Eigen/Geometry>
#endif
#include <cstdio>
#include <cstdlib>
using V = Eigen::Vector3d;
using M = Eigen::Matrix3d;
using V6 = Eigen::Matrix<double, 6, 1>;
template <class T>
T rnd() {
  T t;
  for (int i = 0; i < t.size(); ++i) t.data()[i] = drand48() * 2 - 1;
  return t;
}
template <class T>
void out(const char* n, const T& t) {
  printf("%s", n);
  for (int i = 0; i < t.size(); ++i) printf(" %a", t.data()[i]);
  puts("");
}
int main() {
  for (int k = 0; k < 300; ++k) {
    V a = rnd<V>(), b = rnd<V>();
    M A = rnd<M>(), B = rnd<M>();
    const M Q = rnd<M>();
    double s = drand48();
    V x;
    M X;
    x = a + b;
    out("add", x);
    x = a - b * s;
    out("sub", x);
    x = s * a;
    out("sc", x);
    x = a / s;
    out("div", x);
    x = -a;
    out("neg", x);
    x = a;
    x += b;
    x -= s * a;
    x *= s;
    x /= 0.3;
    out("c", x);
    x = A * b;
    out("Av", x);
    x = A * a + b;
    out("Av+b", x);
    x = a - A * b;
    out("a-Av", x);
    x = A.transpose() * b;
    out("Atv", x);
    x = Q.transpose() * b;
    out("Qtv", x);
    x = -(A.transpose() * b);
    out("-Atv", x);
    x = A * (a - b);
    out("A(a-b)", x);
    x = A.transpose() * (a - b);
    out("At(a-b)", x);
    x = A.transpose() * (2 * a + b);
    out("At(2a+b)", x);
    X = A * B;
    out("AB", X);
    X = A.transpose() * B;
    out("AtB", X);
    X = A * B.transpose();
    out("ABt", X);
    X = A * Q * B;
    out("AQB", X);
    X = A.transpose();
    out("At", X);
    x << a.dot(b), a.norm(), a.squaredNorm();
    out("dot", x);
    x = a.cross(b);
    out("cross", x);
    x = a.normalized();
    out("normd", x);
    x << (a - b).norm(), (a - b).dot(A.col(1)), (A * b).dot(a);
    out("mix", x);
    x << (a + s * b).squaredNorm(), (a - b).dot(a + b), a.dot(A * b);
    out("mix2", x);
    x = (a - b).normalized();
    out("nd2", x);
    x = (a - b).cross(a + b);
    out("cr", x);
    x = A.col(1).cross(b);
    out("colx", x);
    x = A.row(1).transpose();
    out("row", x);
    x = A.col(0) * s + b;
    out("cols", x);
    X = s * A;
    out("sA", X);
    X = A + B;
    out("A+B", X);
    X = a * b.transpose();
    out("abT", X);
    V6 f = rnd<V6>(), g = rnd<V6>();
    f += s * g;
    out("f", f);
    f.head<3>() = a - b;
    f.tail<3>() = A * b;
    out("f2", f);
    x = f.head<3>() + a;
    out("f3", x);
    x = f.tail<3>();
    out("f4", x);
    x = a.cwiseMax(b);
    out("mx", x);
    X = M::Identity();
    out("I", X);
    X = A - A.transpose();
    out("A-At", X);
    x = (A.transpose() * B).col(0);
    out("col", x);
  }
}
