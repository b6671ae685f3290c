/* For the guest kernel on processors with AMX. User Mode Linux 6.1 keeps a process's extended registers in a buffer of
 * fixed size, and ptrace refuses to write back a part of them (x86 XSAVE area, NT_X86_XSTATE): the guest ends at its first
 * process. Loaded before it, this answers with the part that the guest has room for, and puts that part into the whole
 * when it is written back. Built by fetch.sh, used by the scripts beside it. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#define NT_X86_XSTATE 0x202

static long ask(long request, long pid, void *address, void *data)
{
    return syscall(SYS_ptrace, request, pid, address, data);
}

static long registers(long request, long pid, struct iovec *part)
{
    static __attribute__((aligned(64))) char area[1 << 15];
    struct iovec whole = {area, sizeof area};
    if (ask(PTRACE_GETREGSET, pid, (void *)NT_X86_XSTATE, &whole) < 0)
        return -1;
    size_t length = part->iov_len < whole.iov_len ? part->iov_len : whole.iov_len;
    if (request == PTRACE_GETREGSET) {
        memcpy(part->iov_base, area, length);
        part->iov_len = length;
        return 0;
    }
    memcpy(area, part->iov_base, length);
    return ask(PTRACE_SETREGSET, pid, (void *)NT_X86_XSTATE, &whole);
}

long ptrace(enum __ptrace_request request, ...)
{
    va_list more;
    va_start(more, request);
    long pid = va_arg(more, pid_t);
    void *address = va_arg(more, void *);
    void *data = va_arg(more, void *);
    va_end(more);
    if ((request == PTRACE_GETREGSET || request == PTRACE_SETREGSET) && (long)address == NT_X86_XSTATE)
        return registers(request, pid, data);
    if (request == PTRACE_PEEKTEXT || request == PTRACE_PEEKDATA || request == PTRACE_PEEKUSER) {
        /* The system call puts the word where the library's function returns it. */
        long word;
        if (ask(request, pid, address, &word) < 0)
            return -1;
        errno = 0;
        return word;
    }
    return ask(request, pid, address, data);
}
