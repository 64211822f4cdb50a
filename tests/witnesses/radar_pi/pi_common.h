// What the socket code of radar_pi takes of wxWidgets and of Linux, without windows.
#pragma once
#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <stdint.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>
#include <wx/intl.h>
#include <wx/log.h>
#include <wx/longlong.h>
#include <wx/string.h>
#include <wx/thread.h>
#include <wx/time.h>
#include <wx/utils.h>
using namespace std;
#define PLUGIN_BEGIN_NAMESPACE namespace RadarPlugin {
#define PLUGIN_END_NAMESPACE }
#define SOCKET int
#define INVALID_SOCKET ((SOCKET)~0)
#define SOCKETERRSTR (strerror(errno))
#define closesocket(fd) close(fd)
#define MILLISECONDS_PER_SECOND (1000)
#define DEGREES_PER_ROTATION (360)
#define ARRAY_SIZE(x) (sizeof(x) / sizeof(x[0]))
#define CLEAR_STRUCT(x) memset(&x, 0, sizeof(x))
