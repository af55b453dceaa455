/* Stand-in for the SDK of Force Dimension: an omega.7, or an omega.3 with serial number 3, that moves 30 mm down (z)
 * within 300 readings
 * after its first 300. The forces go to the file of DHD_LOG; with DHD_FAIL the device fails at reading 700. */
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "dhdc.h"

namespace {
int serial = 0, readings = 0;
std::FILE* log_file = nullptr;
const char* name_of(int number) { return number == 3 ? "omega.3" : "omega.7"; }
}  // namespace

extern "C" {
int dhdOpen() { return dhdOpenSerial(7); }
int dhdOpenSerial(int number) {
  if (number != 3 && number != 7) return -1;
  serial = number, readings = 0;
  if (const char* file = std::getenv("DHD_LOG")) log_file = std::fopen(file, "w");
  return 5;
}
int dhdClose(char ID) {
  if (log_file != nullptr) std::fclose(log_file);
  log_file = nullptr;
  return ID == 5 ? 0 : -1;
}
int dhdEnableForce(uchar, char ID) { return ID == 5 ? 0 : -1; }
int dhdSetGravityCompensation(int, char ID) { return ID == 5 ? 0 : -1; }
const char* dhdGetSystemName(char) { return name_of(serial); }
const char* dhdErrorGetLastStr() { return "no device found"; }
bool dhdHasWrist(char) { return serial == 7; }
bool dhdHasActiveWrist(char) { return false; }
bool dhdHasGripper(char) { return serial == 7; }
int dhdGetPosition(double* px, double* py, double* pz, char) {
  ++readings;
  *px = *py = 0.0;
  *pz = -0.03 * std::fmin(1.0, std::fmax(0.0, readings / 300.0 - 1.0));
  return std::getenv("DHD_FAIL") != nullptr && readings > 700 ? -1 : 0;
}
int dhdGetPositionAndOrientationFrame(double* px, double* py, double* pz, double R[3][3], char ID) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R[i][j] = i == j ? 1.0 : 0.0;
  return dhdGetPosition(px, py, pz, ID);
}
int dhdGetGripperAngleRad(double* a, char) {
  *a = -0.3;
  return 0;
}
uint dhdGetButtonMask(char) { return 12; }
int dhdSetForceAndTorque(double fx, double fy, double fz, double, double, double, char) {
  if (log_file != nullptr) std::fprintf(log_file, "%g %g %g\n", fx, fy, fz), std::fflush(log_file);
  return 0;
}
}
