/* The part of Novint's HDAL that palpate/devices/novint.cpp uses, declared as the vendor's programmer's guide names and
 * types it. */
#ifndef HDL_H
#define HDL_H
#define HDL_NO_ERROR 0x0
#define HDL_INVALID_HANDLE -1
#define HDL_SERVOOP_EXIT 0
#define HDL_SERVOOP_CONTINUE 1
#define HDL_BUTTON_1 0x00000001
#define HDL_BUTTON_2 0x00000002
#define HDL_BUTTON_3 0x00000004
#define HDL_BUTTON_4 0x00000008
#define HDAL_NOT_CALIBRATED 0x04
typedef int HDLError, HDLDeviceHandle, HDLServoOpExitCode, HDLOpHandle;
typedef HDLServoOpExitCode HDLServoOp(void* pParam);
extern "C" {
HDLError hdlGetError();
HDLDeviceHandle hdlInitNamedDevice(const char* deviceName, const char* configPath = 0);
void hdlStart();
void hdlStop();
unsigned int hdlGetState();
void hdlUninitDevice(HDLDeviceHandle hHandle);
void hdlMakeCurrent(HDLDeviceHandle hHandle);
void hdlDeviceWorkspace(double workspaceDimensions[6]);
void hdlSetToolForce(double force[3]);
void hdlToolPosition(double position[3]);
void hdlToolButtons(int* pButton);
HDLOpHandle hdlCreateServoOp(HDLServoOp pServoOp, void* pParam, bool bBlocking);
void hdlDestroyServoOp(HDLOpHandle hServoOp);
}
#endif
