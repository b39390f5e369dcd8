// Aligned samples of 16 elements to the numbers of solver.v: sums of products by lags, forward-backward as a real
// symmetric matrix, one power of two by its trace, diagonal loading. And the sum of all. A sample takes 121 clocks. See docs/fpga.md.
module real_form #(
    parameter TABLE = "real_form.hex",
    parameter ENTRIES = 63         // of it
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no word is taken
    input wire [15:0] loading,     // delta/8, 2^-20
    input wire in_valid,
    output wire in_ready,
    input wire [31:0] in_word,     // {re, im} of element 0, ..., element 15; from -32767 on
    input wire in_end,             // with element 15: the line's last sample
    output wire out_valid,
    input wire out_ready,
    output reg [31:0] out_number,
    output reg [6:0] out_address,
    output reg out_last,           // of the sample
    output wire out_end,           // of the line
    output wire [4:0] out_exponent // constant in a sample; 0 without power
);
    // --- Words to one of two banks.
    reg [31:0] words [0:31];
    reg [1:0] full, full_end;
    reg in_bank, bank;
    reg [3:0] in_element;
    wire taken = in_valid && in_ready;
    wire consumed;
    assign in_ready = enable && !full[in_bank];
    always @(posedge clock) begin
        if (taken) words[{in_bank, in_element}] <= in_word;
        if (taken) in_element <= in_element + 1'b1;
        if (taken && &in_element) begin
            full[in_bank] <= 1;
            full_end[in_bank] <= in_end;
            in_bank <= !in_bank;
        end
        if (consumed) full[bank] <= 0;
        if (reset) begin
            full <= 0;
            {in_element, in_bank} <= 0;
        end
    end

    // --- Products of lag 0 to 7; as lag 8 the words themselves.
    reg [1:0] summed, summed_end;  // banks of sums
    reg sum_bank, read_bank, running;
    reg [3:0] lag, first;
    wire data = lag[3];
    wire last_product = first == (data ? 4'd15 : 4'd15 - lag);
    assign consumed = running && data && last_product;
    wire [3:0] second = data ? first : first + lag;
    always @(posedge clock) begin
        if (!running) begin
            running <= full[bank] && !summed[sum_bank] && !closing;
            {lag, first} <= 0;
        end else begin
            first <= last_product ? 4'd0 : first + 1'b1;
            if (last_product) lag <= lag + 1'b1;
            if (consumed) begin
                running <= 0;
                bank <= !bank;
            end
        end
        if (reset) {running, bank} <= 0;
    end

    reg [31:0] a_1, b_1;
    reg signed [31:0] rr_2, ii_2, ir_2, ri_2;
    reg signed [32:0] re_3, im_3;
    reg [65:0] products [0:15];
    reg signed [33:0] re_4, im_4;
    reg [36:0] re_all, im_all, re_ended, im_ended;   // the sum of all products of a lag
    reg signed [35:0] re_5, im_5;
    reg [3:0] first_1, first_2, first_3, first_4, first_5, lag_1, lag_2, lag_3, lag_4, lag_5;
    reg [5:1] valid;
    wire signed [15:0] ar = a_1[31:16], ai = a_1[15:0], br = b_1[31:16], bi = b_1[15:0];
    reg [3:0] gone_3;
    reg goes_3;
    wire [65:0] past = goes_3 ? products[gone_3] : 66'd0;
    always @(posedge clock) begin
        a_1 <= words[{bank, second}];
        b_1 <= data ? {16'd1, 16'd0} : words[{bank, first}];
        rr_2 <= ar * br;
        ii_2 <= ai * bi;
        ir_2 <= ai * br;
        ri_2 <= ar * bi;
        re_3 <= {rr_2[31], rr_2} + {ii_2[31], ii_2};
        im_3 <= {ir_2[31], ir_2} - {ri_2[31], ri_2};
        gone_3 <= first_2 - 4'd9;
        goes_3 <= first_2 >= 9;
        products[first_3] <= {re_3, im_3};
        re_4 <= {re_3[32], re_3} - {past[65], past[65:33]};
        im_4 <= {im_3[32], im_3} - {past[32], past[32:0]};
        re_all <= (first_3 == 0 ? 37'd0 : re_all) + {{4{re_3[32]}}, re_3};
        im_all <= (first_3 == 0 ? 37'd0 : im_all) + {{4{im_3[32]}}, im_3};
        if (&first_4) {re_ended, im_ended} <= {re_all, im_all};
        re_5 <= (first_4 == 0 ? 36'd0 : re_5) + {{2{re_4[33]}}, re_4};
        im_5 <= (first_4 == 0 ? 36'd0 : im_5) + {{2{im_4[33]}}, im_4};
        {first_5, first_4, first_3, first_2, first_1} <= {first_4, first_3, first_2, first_1, first};
        {lag_5, lag_4, lag_3, lag_2, lag_1} <= {lag_4, lag_3, lag_2, lag_1, lag};
        valid <= {valid[4:1], running};
        if (reset) valid <= 0;
    end

    // --- A sum and its mirror image along the diagonal.
    reg [71:0] earlier [0:3];
    wire [3:0] mirror_4 = 4'd15 - lag_4 - first_4;
    reg [2:0] column_5;
    reg [1:0] mirror_5;
    reg middle_5, later_5;
    wire [71:0] image = middle_5 ? {re_5, im_5} : earlier[mirror_5];
    reg signed [36:0] re_6, im_6;
    reg [5:0] place_6;
    reg write_6, ends_6, last_6, power_6;
    reg [73:0] sums_f [0:127], sums_g [0:127];
    always @(posedge clock) begin
        {column_5, mirror_5} <= {first_4[2:0], mirror_4[1:0]};
        middle_5 <= mirror_4 == {1'b0, first_4[2:0]};
        later_5 <= mirror_4 <= {1'b0, first_4[2:0]};
        if (valid[5] && first_5[3] && !column_5[2]) earlier[column_5[1:0]] <= {re_5, im_5};
        ends_6 <= valid[5] && lag_5[3] && (&first_5);
        last_6 <= ends_6;
        re_6 <= {re_5[35], re_5} + (lag_5[3] ? 37'd0 : {image[71], image[71:36]});
        im_6 <= {im_5[35], im_5} + (lag_5[3] ? 37'd0 : {image[35], image[35:0]});
        place_6 <= lag_5[3] ? {3'b100, column_5} : {1'b0, lag_5[2:0], mirror_5};
        write_6 <= valid[5] && first_5[3] && (lag_5[3] || later_5);
        power_6 <= lag_5 == 0;
        if (ends_6) begin
            {re_6, im_6} <= {re_ended, im_ended};
            place_6 <= 40;
            write_6 <= 1;
        end
        if (write_6) begin
            sums_f[{sum_bank, place_6}] <= {re_6, im_6};
            sums_g[{sum_bank, place_6}] <= {re_6, im_6};
        end
        if (reset) {write_6, ends_6, last_6} <= 0;
    end

    // --- The trace, and its leading zeros of 39 bits, during the other lags.
    reg [38:0] trace;
    reg [5:0] zeros;
    reg normal;
    reg [16:0] traces [0:1];
    reg [5:0] shifts [0:1];
    wire closing = |valid || write_6;
    wire emitted;
    always @(posedge clock) begin
        if (write_6 && power_6) begin
            trace <= (place_6 == 3 ? 39'd0 : trace) + {1'b0, re_6, 1'b0};
            zeros <= 0;
            normal <= place_6 == 0;
        end else if (normal && !trace[38] && zeros != 38) begin
            trace <= trace << 1;
            zeros <= zeros + 1'b1;
        end
        if (last_6) begin
            traces[sum_bank] <= trace[38:22];
            shifts[sum_bank] <= zeros;
            summed[sum_bank] <= 1;
            summed_end[sum_bank] <= full_end[!bank];
            sum_bank <= !sum_bank;
        end
        if (emitted) begin
            summed[read_bank] <= 0;
            read_bank <= !read_bank;
        end
        if (reset) begin
            summed <= 0;
            {sum_bank, read_bank, normal} <= 0;
        end
    end

    // --- The numbers of a sample, one after the other.
    localparam [5:0] LAST = ENTRIES[5:0] - 1'b1;
    localparam [31:0] STEERING = 32'h80000, GAIN = 32'h71c71c;
    reg [24:0] entries [0:ENTRIES-1];
    initial $readmemh(TABLE, entries);
    reg [5:0] next;
    reg issued;                    // all of them
    reg [8:1] moves;
    reg [7:1] last;
    assign out_valid = moves[8];
    wire advance = !out_valid || out_ready;
    assign emitted = out_valid && out_ready && out_last;

    reg [16:0] trace_read;
    reg [5:0] zeros_read;
    wire [4:0] half_zeros = zeros_read[5:1] + {4'd0, zeros_read[0]};
    reg [32:0] loaded;
    wire unused = &{entry_7[23], entry_7[21:9], loaded[10:0], shifted_7[12:0], zeros_read[5]};
    assign out_exponent = trace_read[16] ? 5'd20 - half_zeros : 5'd0;
    assign out_end = summed_end[read_bank];

    reg [24:0] entry_1, entry_2, entry_3, entry_4, entry_5, entry_6, entry_7;
    reg [73:0] f_2, g_2, f_3, g_3;
    reg signed [37:0] value_4;
    reg signed [38:0] value_5;
    reg [5:0] shift_5;
    reg [2:0] shift_6;
    reg [44:0] shifted_6, shifted_7;
    wire imaginary = entry_3[19] ^ entry_3[20];
    wire signed [36:0] f = imaginary ? f_3[36:0] : f_3[73:37], g = imaginary ? g_3[36:0] : g_3[73:37];
    always @(posedge clock) begin
        trace_read <= traces[read_bank];
        zeros_read <= shifts[read_bank];
        loaded <= trace_read * loading;
        if (advance) begin
            moves <= {moves[7:1], summed[read_bank] && !issued};
            last <= {last[6:1], next == LAST};
            if (summed[read_bank] && !issued) begin
                next <= next == LAST ? 6'd0 : next + 1'b1;
                issued <= next == LAST;
            end
            entry_1 <= entries[next];
            {entry_7, entry_6, entry_5, entry_4, entry_3, entry_2} <= {entry_6, entry_5, entry_4, entry_3, entry_2, entry_1};
            f_2 <= sums_f[{read_bank, entry_1[12:7]}];
            g_2 <= sums_g[{read_bank, entry_1[18:13]}];
            {f_3, g_3} <= {f_2, g_2};
            value_4 <= entry_3[19] ? {f[36], f} - {g[36], g} : {f[36], f} + {g[36], g};
            value_5 <= entry_4[24] ? 39'd0 : entry_4[21] ? -{value_4[37], value_4} : {value_4[37], value_4};
            shift_5 <= entry_4[23] ? 6'd21 + {1'b0, half_zeros} : zeros_read;
            shifted_6 <= {{6{value_5[38]}}, value_5} << {shift_5[5:3], 3'd0};
            shift_6 <= shift_5[2:0];
            shifted_7 <= shifted_6 << shift_6;
            out_number <= shifted_7[44:13] + (entry_7[22] ? {10'd0, loaded[32:11]}
                : !entry_7[24] ? 32'd0 : entry_7[8] ? GAIN : entry_7[7] ? STEERING : 32'd0);
            out_address <= entry_7[6:0];
            out_last <= last[7];
        end
        if (emitted) issued <= 0;
        if (reset) {moves, next, issued} <= 0;
    end
endmodule
