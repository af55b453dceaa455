/* The part of Force Dimension's SDK that palpate/devices/force_dimension.cpp uses, declared as the vendor's
 * documentation names and types it. As there, a device is a char, and -1 is the one that was opened last. */
#ifndef DHDC_H
#define DHDC_H
#define DHD_ON 1
#define DHD_OFF 0
typedef unsigned char uchar;
typedef unsigned int uint;
extern "C" {
int dhdOpen();
int dhdOpenSerial(int serial);
int dhdClose(char ID = -1);
int dhdEnableForce(uchar val, char ID = -1);
int dhdSetGravityCompensation(int val = DHD_ON, char ID = -1);
const char* dhdGetSystemName(char ID = -1);
const char* dhdErrorGetLastStr();
bool dhdHasWrist(char ID = -1);
bool dhdHasActiveWrist(char ID = -1);
bool dhdHasGripper(char ID = -1);
int dhdGetPosition(double* px, double* py, double* pz, char ID = -1);
int dhdGetPositionAndOrientationFrame(double* px, double* py, double* pz, double matrix[3][3], char ID = -1);
int dhdGetGripperAngleRad(double* a, char ID = -1);
uint dhdGetButtonMask(char ID = -1);
int dhdSetForceAndTorque(double fx, double fy, double fz, double ta, double tb, double tg, char ID = -1);
}
#endif
