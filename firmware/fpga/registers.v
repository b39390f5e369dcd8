// Registers of 32 bits behind AXI-Lite: written whole, and read. The last address is a count of blocks instead. A reset
// clears register 0 alone.
module registers #(
    parameter COUNT = 16           // a power of two
) (
    input wire clock,
    input wire reset,
    input wire [$clog2(COUNT)+1:0] s_axil_awaddr,
    input wire s_axil_awvalid,
    output wire s_axil_awready,
    input wire [31:0] s_axil_wdata,
    input wire [3:0] s_axil_wstrb,
    input wire s_axil_wvalid,
    output wire s_axil_wready,
    output wire [1:0] s_axil_bresp,
    output reg s_axil_bvalid,
    input wire s_axil_bready,
    input wire [$clog2(COUNT)+1:0] s_axil_araddr,
    input wire s_axil_arvalid,
    output wire s_axil_arready,
    output reg [31:0] s_axil_rdata,
    output wire [1:0] s_axil_rresp,
    output reg s_axil_rvalid,
    input wire s_axil_rready,
    input wire [31:0] status,
    output wire [32*COUNT-1:0] values
);
    localparam A = $clog2(COUNT);
    wire unused = &{s_axil_awaddr[1:0], s_axil_araddr[1:0]};
    // Address and data are taken together.
    wire writes = s_axil_awvalid && s_axil_wvalid && !s_axil_bvalid;
    wire reads = s_axil_arvalid && !s_axil_rvalid;
    assign {s_axil_awready, s_axil_wready} = {2{writes}};
    assign s_axil_arready = reads;
    assign {s_axil_bresp, s_axil_rresp} = 0;
    wire [A-1:0] to = s_axil_awaddr[A+1:2], from = s_axil_araddr[A+1:2];
    reg [31:0] copies [0:COUNT-1];   // to be read without gathering them
    genvar k;
    generate
        for (k = 0; k < COUNT; k = k + 1) begin : register
            reg [31:0] kept;
            assign values[32*k +: 32] = kept;
            always @(posedge clock) begin
                if (writes && to == k[A-1:0] && &s_axil_wstrb) kept <= s_axil_wdata;
                if (k == 0 && reset) kept <= 0;
            end
        end
    endgenerate
    always @(posedge clock) begin
        if (writes && &s_axil_wstrb) copies[to] <= s_axil_wdata;
        if (s_axil_bready) s_axil_bvalid <= 0;
        if (writes) s_axil_bvalid <= 1;
        if (s_axil_rready) s_axil_rvalid <= 0;
        if (reads) begin
            s_axil_rvalid <= 1;
            s_axil_rdata <= &from ? status : from == 0 ? values[31:0] : copies[from];
        end
        if (reset) {s_axil_bvalid, s_axil_rvalid} <= 0;
    end
endmodule
