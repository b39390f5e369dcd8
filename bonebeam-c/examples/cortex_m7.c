/* Starts examples/golden.c on QEMU's mps2-an500, with semihosting for printf. QEMU has zeroed RAM and
 * loaded .data; what is left is to switch on the FPU. */

#include <stdint.h>
#include <stdlib.h>

int main(void);
void initialise_monitor_handles(void);
extern char stack_top[];

__attribute__((noreturn)) static void reset(void) {
    volatile uint32_t *cpacr = (volatile uint32_t *)0xE000ED88;
    *cpacr |= UINT32_C(0xF) << 20;
    __asm__ volatile("dsb\nisb");
    initialise_monitor_handles();
    exit(main());
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {stack_top, reset};
